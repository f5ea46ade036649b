// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/cli/command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string_view>

#include "protocol/base/near_names.h"

namespace mote::cli {
namespace {

constexpr int wrongUsage = 2;

/// Begins what is told of a value that is checked, behind the name of its type: names may have colons.
constexpr const char* checkMark = "\x1f";

/// Values by the words of people: "--threads N (1 to 1024)".
class PlainFormatter : public CLI::Formatter {
  public:
    std::string make_option_opts(const CLI::Option* option) const override {
        if (option->get_type_size() == 0) return CLI::Formatter::make_option_opts(option);
        std::string text = CLI::Formatter::make_option_opts(option);
        for (const auto* const type : {" UINT", " INT", " FLOAT"}) {
            if (text.rfind(type, 0) == 0) text.replace(0, std::string_view(type).size(), " N");
        }
        const std::string type = option->get_type_name(), mark = std::string(":") + checkMark;
        const auto begin = type.find(mark), at = text.find(mark);
        if (begin == std::string::npos || at == std::string::npos) return text;
        const std::string checks = type.substr(begin + mark.size());
        return text.replace(at, type.size() - begin, checks[0] == '{' ? " " + checks : " (" + checks + ")");
    }
};

/// The command that was chosen: the program, or the last subcommand that was named.
const CLI::App& chosenOf(const CLI::App& app) {
    for (const CLI::App* const sub : app.get_subcommands()) {
        if (!sub->get_name().empty()) return chosenOf(*sub);
    }
    return app;
}

/// Adds the options of a command, "--name", its groups' too.
void addOptions(const CLI::App& app, std::vector<std::string>& names) {
    for (const CLI::Option* const option : app.get_options({})) {
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    for (const CLI::App* const group : app.get_subcommands({})) {
        if (group->get_name().empty()) addOptions(*group, names);
    }
}

std::string nearWords(const std::string& word, const std::vector<std::string>& all) {
    return nearNames(word, std::vector<std::string_view>(all.begin(), all.end()));
}

/// What was given and nothing takes, with what may have been meant; "" where everything has its place.
std::string unknownIn(const CLI::App& program) {
    const auto left = program.remaining(true);
    if (left.empty()) return "";
    const CLI::App& app = chosenOf(program);
    const auto option = std::find_if(
        left.begin(), left.end(), [](const auto& word) { return word.size() > 1 && word.starts_with('-'); });
    std::vector<std::string> names;
    if (option != left.end()) {
        const auto name = option->substr(0, option->find('='));
        addOptions(app, names);
        return fmt::format("{}: there is no such option{}", name, nearWords(name, names));
    }
    for (const CLI::App* const sub : app.get_subcommands({})) {
        if (!sub->get_name().empty()) names.push_back(sub->get_name());
    }
    if (!names.empty())
        return fmt::format("there is no subcommand {}{}", left.front(), nearWords(left.front(), names));
    return fmt::format("\"{}\" is one word too many", left.front());
}

/// "Exactly 1 option from [--a,--b] is required and 2 were given", as people say it; else "".
std::string oneOfSentence(const std::string& text) {
    const auto begin = text.find(" option from ["), end = text.find("] is required");
    if (begin == text.npos || end == text.npos || begin > end) return "";
    std::string names = text.substr(begin + 14, end - begin - 14);
    const bool several = text.ends_with("were given");
    for (auto at = names.find(','); at != names.npos; at = names.find(',', at + 2)) {
        const bool last = names.find(',', at + 1) == names.npos;
        names.replace(at, 1, !last ? ", " : several ? " and " : " or ");
    }
    return several ? fmt::format("only one of {} can be given", names) : fmt::format("{} is required", names);
}

/// What is wrong with a command line, as people say it.
std::string sentenceOf(const CLI::App& program, const CLI::ParseError& error) {
    // What is missing may be what was mistyped.
    const bool incomplete = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr ||
                            dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
    if (incomplete) {
        if (auto unknown = unknownIn(program); !unknown.empty()) return unknown;
        if (auto one = oneOfSentence(error.what()); !one.empty()) return one;
    }
    constexpr std::string_view convert = "Could not convert: ", missing = " missing", required = " required ";
    std::string text = error.what();
    if (text.rfind(convert, 0) == 0) {
        const auto equals = text.find(" = ");
        const auto name = text.substr(convert.size(), equals - convert.size());
        return fmt::format("{}: \"{}\" is not a value that it takes", name,
                           text.substr(std::min(equals + 3, text.size())));
    }
    const auto at = text.find(required);
    const auto colon = text.find(':');
    if (at != std::string::npos && colon < at && text.ends_with(missing)) {
        const auto type = text.substr(at + required.size());
        return fmt::format(
            "{} needs a value: {}", text.substr(0, colon),
            type.substr(0, std::min(type.find(std::string(":") + checkMark), type.size() - missing.size())));
    }
    return text;
}

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
    option_->check(
        CLI::Range(least, greatest).description(fmt::format("{}{} to {}", checkMark, least, greatest)));
    return *this;
}

Option Option::range(double least, double greatest) const {
    option_->check(
        CLI::Range(least, greatest).description(fmt::format("{}{} to {}", checkMark, least, greatest)));
    return *this;
}

Option Option::oneOf(const std::vector<std::string>& values) const {
    option_->check(
        CLI::IsMember(values).description(fmt::format("{}{{{}}}", checkMark, fmt::join(values, ","))));
    return *this;
}

Option Option::size(std::uint64_t least, std::uint64_t greatest) const {
    const auto bytes = [](std::string& text) {
        const std::string given = text;
        try {
            if (CLI::AsSizeValue(false)(text).empty()) return std::string();
        } catch (const CLI::ValidationError&) {  // of some it is thrown
        }
        return fmt::format("\"{}\" is no size; one is 512M or 8G", given);
    };
    option_->transform(CLI::Validator(bytes, ""))->check(CLI::Range(least, greatest).description(""));
    return *this;
}

Option Option::folder() const {
    option_->check(CLI::Validator(CLI::ExistingDirectory).description(""));
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

Program::Program(const std::string& description, const std::string& name)
    : app_(std::make_unique<CLI::App>(description, name)) {
    app_->formatter(std::make_shared<PlainFormatter>());
    app_->set_version_flag("--version", name + " " MOTE_VERSION);
    app_->failure_message([](const CLI::App* app, const CLI::Error& error) {
        const auto* const parsing = dynamic_cast<const CLI::ParseError*>(&error);
        return fmt::format("{}: {}\nRun with --help for more information.\n", app->get_name(),
                           parsing != nullptr ? sentenceOf(*app, *parsing) : error.what());
    });
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
