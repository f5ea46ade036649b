// SPDX-License-Identifier: GPL-3.0-or-later
//
// How --memory is shared out, and the steps that a rank keeps within its share. Functions; the one that asks
// how much memory the machine has is not pure.
#pragma once

#include <cstdint>
#include <memory>

#include "protocol/base/error.h"
#include "server/render/ranks/rank_steps.h"
#include "storage/roots.h"

namespace mote::server {

/// Bytes of `memory` that blocks of datasets may take; the rest is for the program, plans, the device's own
/// form of what it draws, and pictures under way. 0, which is no limit: half of the machine's memory.
/// Errors: invalidArgument, which says what is needed at least.
Result<std::uint64_t> dataMemory(std::uint64_t memory);
/// Of that rest, bytes that pictures under way may take at least (picture_memory.h).
std::uint64_t pictureMemory(std::uint64_t memory);

/// Returns the steps of a file system that all ranks see, beneath roots of the same names; the latest stay
/// open. `memory`: bytes of the steps that were opened. One thread.
std::unique_ptr<render::RankSteps> sharedFileSteps(storage::Roots roots, std::uint64_t memory);

}  // namespace mote::server
