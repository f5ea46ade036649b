// SPDX-License-Identifier: GPL-3.0-or-later
//
// The command line and configuration file of mote-server. Pure, but for the file.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "protocol/scene/error.h"
#include "server/app/server.h"

namespace mote::server {

/// What the file of --config may hold, and the command line overrides. Keys are named as the options are.
struct FileOptions {
    std::vector<std::string> roots;
    std::optional<std::string> state, connection, listen, device, memory;
    std::optional<std::int64_t> threads;
};

/// Errors: notFound, invalidArgument with file, line and key.
Result<FileOptions> readConfig(const std::string& path);

/// "8G", "512M", "1.5GiB", "1000000": bytes, by powers of 1024. Errors: invalidArgument.
Result<std::uint64_t> parseSize(const std::string& text);

/// The settings, or the exit code of a program that has said all (--help, or wrong usage on stderr).
std::variant<ServerSettings, int> parseOptions(int argc, const char* const* argv);

}  // namespace mote::server
