// SPDX-License-Identifier: GPL-3.0-or-later
//
// RowReader: reads any columns of a range of a step's rows, chunk by chunk: one thread reads while others
// work on what was read. A function without state.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

inline constexpr std::uint64_t rowsOfChunk = std::uint64_t{1} << 17;

/// Calls `use` for each chunk of rows [begin, end), in any order, from all threads of the calling arena;
/// `begin` is a multiple of rowsOfChunk. Errors: the source's own, cancelled.
Status forEachChunk(ParticleSource& source, std::size_t step, std::uint64_t begin, std::uint64_t end,
                    const std::vector<Column>& wanted, const Progress& progress,
                    const std::function<void(const ParticleChunk&)>& use);

}  // namespace mote::prep
