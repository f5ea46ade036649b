// SPDX-License-Identifier: GPL-3.0-or-later
//
// The statistics of whole steps, from the source's own values, block by block, each rank some of the blocks.
// What was read is kept for the further passes where the memory holds it. Called from one thread; uses all
// threads of its arena. The same bits for any ranks, threads and memory.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/lost_filter.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {

struct StatisticsRequest {
    ParticleSource* source = nullptr;  ///< as it is, not through a filter
    std::size_t step = 0;              ///< of the source
    LostParticles lost = LostParticles::without;
    std::uint64_t memory = 0;  ///< bytes that this rank may take
    Communicator* ranks = nullptr;
    const Progress* progress = nullptr;
    std::vector<Column> records = {};  ///< that `observe` is shown besides
    /// Called once with each chunk of this rank, from any thread, as it comes from the source.
    std::function<void(const ParticleChunk&)> observe = {};
};

/// By mote::statistics(), of the particles that take part; the source's own where it has them. Errors:
/// the source's own, cancelled; the same on all ranks.
Result<std::vector<double>> stepStatistics(const StatisticsRequest& request);

}  // namespace mote::prep
