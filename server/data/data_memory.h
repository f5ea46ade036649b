// SPDX-License-Identifier: GPL-3.0-or-later
//
// How --memory is shared out. Pure functions, but for asking how much memory the machine has.
#pragma once

#include <cstdint>

#include "protocol/scene/error.h"

namespace mote::server {

/// Bytes of `memory` that blocks of datasets may take; the rest is for the program, plans, the device's own
/// form of what it draws, and pictures under way. 0, which is no limit: half of the machine's memory.
/// Errors: invalidArgument, which says what is needed at least.
Result<std::uint64_t> dataMemory(std::uint64_t memory);

}  // namespace mote::server
