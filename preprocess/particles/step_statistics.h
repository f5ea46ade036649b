// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepStatistics: the statistics of a whole step, from the source's own values, block by block, each rank
// some of the blocks. A first pass over them comes before whatever needs their means, and further ones, for
// percentiles, whenever there is time, or at once where the memory holds what was read or ranks must agree.
// Owned by the job; called from one thread, it uses all threads of its arena. The same bits for any ranks,
// threads and memory.
//
// RowReader: reads any columns of a range of a step's rows, chunk by chunk: one thread reads while others
// work on what was read. A function without state.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/lost_filter.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

inline constexpr std::uint64_t rowsOfChunk = std::uint64_t{1} << 17;

/// Calls `use` for each chunk of rows [begin, end), in any order, from all threads of the calling arena;
/// `begin` is a multiple of rowsOfChunk. Errors: the source's own, cancelled.
Status forEachChunk(ParticleSource& source, std::size_t step, std::uint64_t begin, std::uint64_t end,
                    const std::vector<Column>& wanted, const Progress& progress,
                    const std::function<void(const ParticleChunk&)>& use);

struct StatisticsRequest {
    ParticleSource* source = nullptr;  ///< as it is, not through a filter
    std::size_t step = 0;              ///< of the source
    LostParticles lost = LostParticles::without;
    std::uint64_t memory = 0;  ///< bytes that this rank may take
    Communicator* ranks = nullptr;
    const Progress* progress = nullptr;
    std::vector<Column> observed = {};  ///< what `observe` is shown, and weights
    /// Called once with each chunk of this rank, from any thread, as it comes from the source.
    std::function<void(const ParticleChunk&)> observe = {};
};

class StepStatistics {
  public:
    explicit StepStatistics(StatisticsRequest request);
    ~StepStatistics();

    /// The first pass, which shows all that is observed. Errors: the source's own, cancelled; the same on all
    /// ranks.
    Status begin();
    /// The further passes, if any are left. Errors: as begin().
    Status finish();

    /// The values of mote::statistics(), of the particles that take part; the source's own if it has them.
    /// Between begin() and finish() percentiles may be missing: NaN.
    const std::vector<double>& values() const { return values_; }

  private:
    class Passes;
    const StatisticsRequest request_;
    std::unique_ptr<Passes> passes_;  ///< while any are left
    std::vector<double> values_;
};

}  // namespace mote::prep
