// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sizes as people write them. A pure function.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/base/error.h"

namespace mote::server {

/// "8G", "512M", "1.5GiB", "1000000": bytes, by powers of 1024. Errors: invalidArgument.
Result<std::uint64_t> parseSize(const std::string& text);

}  // namespace mote::server
