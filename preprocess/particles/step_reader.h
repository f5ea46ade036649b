// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepReader: the particles of a step that take part in a plot, with their three plot coordinates, block by
// block and as often as it is asked. One thread reads while others work on what was read. Owned by the job.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/plot_axis.h"

namespace mote::prep {

/// Rows that a step may have: a particle's row is kept in 32 bits while the job works.
inline constexpr std::uint64_t maxStepRows = (std::uint64_t{1} << 32) - 2;

/// What takes part of a block of rows.
struct ParticleBlock {
    std::array<std::vector<double>, 3> coordinate;  ///< by axis of the plot, in its unit; finite
    std::vector<double> weight;                     ///< finite, >= 0
    std::vector<std::uint32_t> row;                 ///< in the source, ascending
    std::uint64_t lost = 0;                         ///< marked as lost by the source
    std::uint64_t invalid = 0;  ///< not lost, but a coordinate is not finite or the weight is no weight

    std::size_t size() const { return row.size(); }
    std::uint64_t bytes() const { return size() * (4 * sizeof(double) + sizeof(std::uint32_t)); }
};

class StepReader {
  public:
    static constexpr std::uint64_t blockRows = std::uint64_t{1} << 18;

    /// A reader of this rank's share of the step's blocks. What it reads is kept for the next pass where it
    /// takes at most `mayKeep` bytes. All references outlive the reader. Errors: resourceExhausted (too many
    /// rows), the source's own, cancelled; the same on all ranks.
    static Result<StepReader> open(ParticleSource& source, std::size_t step, const PlotAxes& axes,
                                   Communicator& ranks, const Progress& progress, std::uint64_t mayKeep);

    StepReader(StepReader&&) noexcept;
    ~StepReader();

    std::size_t firstBlock() const { return first_; }  ///< of this rank's blocks, among the step's
    std::size_t blockCount() const { return kept_.size(); }
    std::uint64_t rows() const { return rows_; }  ///< of the whole step
    std::uint64_t keptBytes() const { return keptBytes_; }

    /// Calls `use(block, index)` for this rank's blocks [begin, end), counted from 0, in any order, from all
    /// threads of the calling arena. Errors: the source's own, cancelled.
    Status forEach(std::size_t begin, std::size_t end,
                   const std::function<void(const ParticleBlock&, std::size_t)>& use);

  private:
    struct Slot;
    StepReader(ParticleSource& source, std::size_t step, const PlotAxes& axes, const Progress& progress);
    Status readBlock(std::size_t index, const std::vector<Column>& wanted, ParticleChunk& chunk);
    Status findMeans(Communicator& ranks);
    void keep(std::size_t index, Slot& slot);

    ParticleSource* source_;
    std::size_t step_;
    const PlotAxes* axes_;
    const Progress* progress_;
    std::uint64_t rows_ = 0;
    std::size_t first_ = 0;
    bool keeps_ = false;
    std::uint64_t keptBytes_ = 0;
    BeamContext context_;
    std::vector<std::optional<ParticleBlock>> kept_;  ///< by block of this rank
    std::vector<std::unique_ptr<Slot>> slots_;        ///< used again by each pass
};

}  // namespace mote::prep
