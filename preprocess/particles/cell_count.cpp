// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/cell_count.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>

#include "preprocess/particles/quantized_block.h"

namespace mote::prep {
namespace {

struct Counter {
    CellCount count;
    QuantizedBlock block;
};

/// What a rank tells of itself beside its cells.
struct Rest {
    std::uint64_t lost, invalid, outside;
    Range weight;
};

void countBlock(const ParticleBlock& block, const std::array<Range, 3>& bounds, unsigned gridLevel,
                Counter& counter) {
    auto& count = counter.count;
    count.cells.resize(std::size_t{1} << (3 * gridLevel));
    quantize(block, bounds, counter.block);
    count.lost += block.lost;
    count.invalid += block.invalid;
    count.outside += counter.block.outside;
    for (const auto& particle : counter.block.particles) ++count.cells[gridCellOf(particle, gridLevel)];
    const auto& weight = counter.block.weight;
    if (weight.empty()) return;
    const auto [least, greatest] = std::minmax_element(weight.begin(), weight.end());
    count.weight = count.weight.united({*least, *greatest});
}

}  // namespace

void CellCount::add(const CellCount& other) {
    cells.resize(std::max(cells.size(), other.cells.size()));
    for (std::size_t cell = 0; cell < other.cells.size(); ++cell) cells[cell] += other.cells[cell];
    lost += other.lost;
    invalid += other.invalid;
    outside += other.outside;
    weight = weight.united(other.weight);
}

Result<CellCount> countCells(StepReader& reader, const std::array<Range, 3>& bounds, unsigned gridLevel) {
    tbb::enumerable_thread_specific<Counter> counters;
    MOTE_RETURN_IF_ERROR(reader.forEach(0, reader.blockCount(), [&](const ParticleBlock& block, std::size_t) {
        countBlock(block, bounds, gridLevel, counters.local());
    }));
    CellCount count;
    count.cells.resize(std::size_t{1} << (3 * gridLevel));
    for (const auto& counter : counters) count.add(counter.count);
    return count;
}

Result<CellCount> sumOfRanks(Communicator& ranks, const CellCount& mine) {
    if (ranks.size() == 1) return mine;
    MOTE_ASSIGN_OR_RETURN(const auto cells, shareValues<std::uint32_t>(ranks, mine.cells));
    const Rest rest{mine.lost, mine.invalid, mine.outside, mine.weight};
    MOTE_ASSIGN_OR_RETURN(const auto rests, shareValues<Rest>(ranks, std::span(&rest, 1)));
    CellCount sum;
    for (std::size_t rank = 0; rank < cells.size(); ++rank) {
        const Rest& other = rests[rank].front();
        sum.add({std::move(cells[rank]), other.lost, other.invalid, other.outside, other.weight});
    }
    return sum;
}

}  // namespace mote::prep
