// SPDX-License-Identifier: GPL-3.0-or-later
//
// The command line of mote-server, and what is checked of it. Pure, but for reading files.
#pragma once

#include <variant>

#include "server/app/server.h"

namespace mote::server {

/// The settings, or the exit code of a program that has said all: --help, --check-config, or wrong usage on
/// stderr.
std::variant<ServerSettings, int> parseOptions(int argc, const char* const* argv);

}  // namespace mote::server
