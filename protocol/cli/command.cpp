// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/cli/command.h"

#include <CLI/CLI.hpp>
#include <filesystem>

namespace mote::cli {
namespace {

constexpr int wrongUsage = 2;

}  // namespace

Option Option::required() const {
    option_->required();
    return *this;
}

Option Option::valueName(const std::string& name) const {
    option_->type_name(name);
    return *this;
}

Option Option::showDefault() const {
    option_->capture_default_str();
    return *this;
}

Option Option::showDefault(const std::string& text) const {
    option_->default_str(text);
    return *this;
}

Option Option::range(int least, int greatest) const {
    option_->check(CLI::Range(least, greatest));
    return *this;
}

Option Option::range(double least, double greatest) const {
    option_->check(CLI::Range(least, greatest));
    return *this;
}

Option Option::oneOf(const std::vector<std::string>& values) const {
    option_->check(CLI::IsMember(values));
    return *this;
}

Option Option::size(std::uint64_t least, std::uint64_t greatest) const {
    option_->transform(CLI::AsSizeValue(false))->check(CLI::Range(least, greatest));
    return *this;
}

Option Option::folder() const {
    option_->check(CLI::ExistingDirectory);
    return *this;
}

Option Option::values(int count) const {
    option_->expected(count);
    return *this;
}

Option Option::repeatable() const {
    option_->allow_extra_args(false);
    return *this;
}

Option Option::excludes(const Option& other) const {
    option_->excludes(other.option_);
    return *this;
}

Option Option::hidden() const {
    option_->group("");
    return *this;
}

Command Command::subcommand(const std::string& name, const std::string& description) const {
    return Command(app_->add_subcommand(name, description));
}

Command Command::group(const std::string& name, const std::string& description) const {
    return Command(app_->add_option_group(name, description));
}

template <class T>
Option Command::option(const std::string& name, T& value, const std::string& description) const {
    return Option(app_->add_option(name, value, description));
}

template <class T>
Option Command::takes(const std::string& name, std::function<void(const T&)> take,
                      const std::string& description) const {
    return Option(app_->add_option_function<T>(name, take, description));
}

Option Command::flag(const std::string& name, bool& value, const std::string& description) const {
    return Option(app_->add_flag(name, value, description));
}

Option Command::flag(const std::string& name, std::function<void()> given,
                     const std::string& description) const {
    return Option(app_->add_flag_callback(name, std::move(given), description));
}

void Command::footer(const std::string& text) const {
    app_->footer(text);
}

void Command::requireOneSubcommand() const {
    app_->require_subcommand(1);
}

void Command::requireOneOption() const {
    app_->require_option(1);
}

void Command::callback(std::function<void()> chosen) const {
    app_->callback(std::move(chosen));
}

std::size_t Command::count(const std::string& name) const {
    return app_->count(name);
}

Program::Program(const std::string& description, const std::string& name, const std::string& version)
    : app_(std::make_unique<CLI::App>(description, name)) {
    if (!version.empty()) app_->set_version_flag("--version", version);
}

Program::~Program() = default;

Command Program::command() const {
    return Command(app_.get());
}

std::optional<int> Program::parse(int argc, const char* const* argv,
                                  const std::function<Status()>& check) const {
    try {
        app_->parse(argc, argv);
        const auto checked = check ? check() : success();
        if (!checked.ok()) throw CLI::ValidationError(checked.error().where, checked.error().message);
    } catch (const CLI::ParseError& error) {
        return app_->exit(error) == 0 ? 0 : wrongUsage;
    }
    return std::nullopt;
}

std::optional<double> parseNumber(const std::string& text) {
    double number = 0.0;
    return CLI::detail::lexical_cast(text, number) ? std::optional(number) : std::nullopt;
}

#define MOTE_OPTION_OF(...) \
    template Option Command::option(const std::string&, __VA_ARGS__&, const std::string&) const;
MOTE_OPTION_OF(int)
MOTE_OPTION_OF(std::uint32_t)
MOTE_OPTION_OF(std::int64_t)
MOTE_OPTION_OF(std::uint64_t)
MOTE_OPTION_OF(double)
MOTE_OPTION_OF(std::string)
MOTE_OPTION_OF(std::filesystem::path)
MOTE_OPTION_OF(std::optional<std::uint32_t>)
MOTE_OPTION_OF(std::optional<std::uint64_t>)
MOTE_OPTION_OF(std::optional<double>)
MOTE_OPTION_OF(std::optional<std::filesystem::path>)
MOTE_OPTION_OF(std::vector<std::uint32_t>)
MOTE_OPTION_OF(std::vector<double>)
MOTE_OPTION_OF(std::vector<std::string>)
#undef MOTE_OPTION_OF

#define MOTE_TAKES(...)                                                                         \
    template Option Command::takes(const std::string&, std::function<void(const __VA_ARGS__&)>, \
                                   const std::string&) const;
MOTE_TAKES(std::uint32_t)
MOTE_TAKES(std::uint64_t)
MOTE_TAKES(double)
MOTE_TAKES(std::string)
MOTE_TAKES(std::vector<std::uint32_t>)
MOTE_TAKES(std::vector<std::uint64_t>)
MOTE_TAKES(std::vector<double>)
MOTE_TAKES(std::vector<std::string>)
#undef MOTE_TAKES

}  // namespace mote::cli
