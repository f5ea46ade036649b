// SPDX-License-Identifier: GPL-3.0-or-later
//
// ServerOption: one option of mote-server, which the command line knows as --NAME and the configuration file
// as NAME. The table of all of them is the one place to add another: a member of ServerSettings, and a row.
// Values, free of threads.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "protocol/base/error.h"
#include "server/app/server.h"

namespace mote::server {

/// A whole number in [least, greatest].
struct WholeNumber {
    unsigned ServerSettings::*value;
    unsigned least, greatest;
};

/// Whole seconds, `greatest` at most.
struct Seconds {
    std::chrono::milliseconds ServerSettings::*value;
    unsigned greatest;
};

/// Bytes, as "8G".
struct Size {
    std::uint64_t ServerSettings::*value;
};

/// One of some words.
struct Choice {
    std::string ServerSettings::*value;
    std::vector<std::string_view> words;
};

/// Where HTTP is answered: "unix:PATH" or "127.0.0.1:PORT".
struct HttpAddress {
    std::string ServerSettings::*value;
};

/// Where a value goes, which says what is read as one: a text, unless it is a list, a flag or a number.
using OptionTarget =
    std::variant<std::vector<std::string> ServerSettings::*, std::filesystem::path ServerSettings::*,
                 std::string ServerSettings::*, render::DeviceKind ServerSettings::*, bool ServerSettings::*,
                 std::optional<wire::Address> ServerSettings::*, WholeNumber, Seconds, Size, Choice,
                 HttpAddress>;

struct ServerOption {
    const char* name;
    OptionTarget target;
    const char* valueName;  ///< how --help calls a value; empty of a flag
    const char* help;
    bool needed = false;  ///< there is no server without it

    bool isList() const { return target.index() == 0; }
    bool isFlag() const { return std::holds_alternative<bool ServerSettings::*>(target); }
    bool isNumber() const {
        return std::holds_alternative<WholeNumber>(target) || std::holds_alternative<Seconds>(target);
    }
    /// Sets it to what was given, as text; a flag's is "true" or "false". Errors: invalidArgument, which does
    /// not name the option.
    Status set(const std::vector<std::string>& values, ServerSettings& settings) const;
};

/// In the order in which --help tells of them.
std::span<const ServerOption> serverOptions();
/// The option of that name, or null.
const ServerOption* findOption(std::string_view name);

}  // namespace mote::server
