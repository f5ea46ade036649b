// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticleExchange: brings every particle of a step to the rank that owns its range of cells, into a store in
// the order of the ranges and, within each, of the rows. One object a step and rank, used from one thread;
// works on all threads of its arena.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/cell_plan.h"
#include "preprocess/particles/record_store.h"
#include "preprocess/particles/step_reader.h"

namespace mote::prep {

/// The particles of a rank's ranges.
struct SortedParticles {
    RecordStore particles;
    RecordStore weights;  ///< doubles; empty where all particles have the same
};

class ParticleExchange {
  public:
    /// All references outlive this.
    ParticleExchange(const CellPlan& plan, Communicator& ranks, bool withWeights);

    /// Each rank's first range, and one more.
    const std::vector<std::size_t>& firstRange() const { return firstRange_; }

    /// `cells`: this rank's particles by cell of the grid. `store` has room for those of its ranges. Errors:
    /// the source's own, resourceExhausted (disk full), cancelled; the same on all ranks.
    Status run(StepReader& reader, const std::array<Range, 3>& bounds,
               const std::vector<std::uint32_t>& cells, SortedParticles& store);

  private:
    /// A block of rows, sorted by range.
    struct Batch {
        std::vector<std::uint32_t> counts;  ///< by range
        std::vector<Particle> particles;
        std::vector<double> weights;
    };

    /// A batch's particles of this rank's ranges, wherever they came from.
    struct Share {
        std::span<const std::uint32_t> counts;  ///< by range of this rank
        std::span<const Particle> particles;
        std::span<const double> weights;
    };

    void assignRanges();
    std::size_t rangesOf(std::size_t rank) const { return firstRange_[rank + 1] - firstRange_[rank]; }
    Status findPlaces(const std::vector<std::uint32_t>& cells);
    Result<std::size_t> findRounds(const StepReader& reader);
    void sortByRange(const QuantizedBlock& block, Batch& batch) const;
    Share shareOf(const Batch& batch, std::size_t rank) const;
    Status deliver(const std::vector<Batch>& batches, SortedParticles& store);
    Status place(std::size_t from, const std::vector<Share>& shares, SortedParticles& store);
    Bytes pack(const std::vector<Batch>& batches, std::size_t rank) const;
    std::vector<Share> unpack(const Bytes& bytes) const;

    const CellPlan& plan_;
    Communicator& ranks_;
    bool withWeights_;
    std::vector<std::size_t> firstRange_;
    /// Where the next particle from a rank goes: by rank, by range of this rank.
    std::vector<std::vector<std::uint64_t>> next_;
};

}  // namespace mote::prep
