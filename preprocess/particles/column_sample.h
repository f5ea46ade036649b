// SPDX-License-Identifier: GPL-3.0-or-later
//
// ColumnSample: rows of a step that its plot holds, evenly strided in the order of its points, with what the
// columns beside them are made from. How columns are coded is chosen by them, not by what the source holds
// besides: lost particles, and those beyond the bounds. Filled while all rows are read for something else.
// Owned by the job; take() may be called from any thread, all else from one.
#pragma once

#include <cstdint>
#include <limits>
#include <mutex>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/lost_filter.h"
#include "preprocess/readers/particle_source.h"
#include "storage/particles/step_file.h"

namespace mote::prep {

class ColumnSample {
  public:
    static constexpr std::uint64_t most = std::uint64_t{1} << 16;

    /// Rows of the step's points; `wanted` is what is kept of them, `lost` which particles take part. Errors:
    /// internal, cancelled.
    static Result<ColumnSample> make(const storage::StepFile& points, std::uint64_t pointCount,
                                     std::vector<Column> wanted, LostParticles lost,
                                     const Progress& progress);
    ColumnSample(ColumnSample&& other) noexcept;

    const std::vector<Column>& wanted() const { return wanted_; }
    /// A chunk of the step, with what is wanted; each chunk once.
    void take(const ParticleChunk& chunk);
    /// What the ranks took, each of rows of its own that ascend with its number, becomes everyone's.
    Status share(Communicator& ranks);

    /// Those that were taken, by ascending row.
    const ParticleChunk& rows() const { return chunk_; }
    /// Of all particles that take part and were read; least above greatest: there was none.
    double leastWeight() const { return leastWeight_; }
    double greatestWeight() const { return greatestWeight_; }

  private:
    ColumnSample() = default;

    std::vector<Column> wanted_;
    LostParticles lost_ = LostParticles::without;
    std::vector<std::uint64_t> row_;  ///< ascending
    std::vector<std::uint8_t> taken_;
    ParticleChunk chunk_;
    std::mutex mutex_;  ///< of the two below
    double leastWeight_ = std::numeric_limits<double>::infinity();
    double greatestWeight_ = -std::numeric_limits<double>::infinity();
};

}  // namespace mote::prep
