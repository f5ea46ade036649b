// SPDX-License-Identifier: GPL-3.0-or-later
//
// The command line of a program: its options, arguments and subcommands, what --help says of them, and what
// is wrong with what was given. CLI11 does the work, in one source: its header is most of what a source with
// it takes to compile. A Program is owned by whoever parses; a Command and an Option are handles into it,
// valid as long as it is. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace mote::cli {

/// What is told of an option while it is declared.
class Option {
  public:
    explicit Option(CLI::Option* option) : option_(option) {}
    Option required() const;
    /// How --help names its value.
    Option valueName(const std::string& name) const;
    /// What --help says is taken where it is not given: what the variable holds now, or this text.
    Option showDefault() const;
    Option showDefault(const std::string& text) const;
    /// Refuses values outside of [least, greatest].
    Option range(int least, int greatest) const;
    Option range(double least, double greatest) const;
    /// Refuses all values but these.
    Option oneOf(const std::vector<std::string>& values) const;
    /// Takes bytes as 8G (of 1024), and refuses sizes outside of [least, greatest].
    Option size(std::uint64_t least, std::uint64_t greatest) const;
    /// Refuses what is not a folder.
    Option folder() const;
    /// Takes as many values each time.
    Option values(int count) const;
    /// One value each time; it may be given again.
    Option repeatable() const;
    /// Not together with `other`.
    Option excludes(const Option& other) const;
    /// --help does not tell of it.
    Option hidden() const;

  private:
    CLI::Option* option_;
};

/// A program, a subcommand, or a group of options.
class Command {
  public:
    explicit Command(CLI::App* app) : app_(app) {}
    Command subcommand(const std::string& name, const std::string& description) const;
    /// Options that --help shows together.
    Command group(const std::string& name, const std::string& description) const;
    /// An option ("--name") or an argument ("NAME") that is put into `value`, which outlives the parsing. T
    /// is a number, a string or a path, an optional or a vector of them: those at the end of command.cpp.
    template <class T>
    Option option(const std::string& name, T& value, const std::string& description = {}) const;
    /// The same, where `take` is given the value, if there is one.
    template <class T>
    Option takes(const std::string& name, std::function<void(const T&)> take,
                 const std::string& description = {}) const;
    Option flag(const std::string& name, bool& value, const std::string& description) const;
    Option flag(const std::string& name, std::function<void()> given, const std::string& description) const;
    /// What --help says at its end.
    void footer(const std::string& text) const;
    /// Exactly one subcommand, or one option of a group, must be given.
    void requireOneSubcommand() const;
    void requireOneOption() const;
    /// Called when all is parsed, where this command was chosen.
    void callback(std::function<void()> chosen) const;
    /// How often an option was given.
    std::size_t count(const std::string& name) const;

  private:
    CLI::App* app_;
};

/// The whole command line.
class Program {
  public:
    /// --version prints the name and the version of Mote.
    Program(const std::string& description, const std::string& name);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    Command command() const;
    /// Parses, then checks. Nothing: go on. A number: end with it, for all is said: 0 after --help and
    /// --version, 2 for wrong usage (an error of `check` is wrong usage of the option `where`).
    std::optional<int> parse(int argc, const char* const* argv,
                             const std::function<Status()>& check = {}) const;

  private:
    std::unique_ptr<CLI::App> app_;
};

/// The whole text as a number, as options take it.
std::optional<double> parseNumber(const std::string& text);

}  // namespace mote::cli
