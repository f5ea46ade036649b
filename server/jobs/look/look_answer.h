// SPDX-License-Identifier: GPL-3.0-or-later
//
// The answer to a look from what mote-prep look --json wrote. A program that reads foreign files wrote it, so
// it is not trusted. A pure function.
#pragma once

#include <string>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::server {

/// `written`: all that the program wrote, one line of which is the JSON object. `path`: what it looked at,
/// in whose place `name` is told. Errors: corrupt (there is no such line, or it is no such object).
Result<proto::Look> lookAnswer(std::string_view written, std::string_view path, const std::string& name);

}  // namespace mote::server
