// SPDX-License-Identifier: GPL-3.0-or-later
//
// The sum of all ranks' counts of the points in each pixel. All ranks call it alike, with as many counts.
#pragma once

#include <cstdint>
#include <span>

#include "server/render/ranks/ranks.h"

namespace mote::render {

/// On rank 0 they become the sums, which stay at the greatest number rather than wrap. Each rank adds up a
/// part of them, so none receives more than twice what there is.
void addUpCounts(Ranks& ranks, std::span<std::uint32_t> counts);

}  // namespace mote::render
