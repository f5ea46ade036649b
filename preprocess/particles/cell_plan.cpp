// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/cell_plan.h"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>

#include "protocol/base/mote_check.h"

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

std::uint32_t fraction(const Range& range, double value) {
    // The division first: multiplying by 2^32 is then exact, so that the cell of any level is the same as the
    // one that floor(2^level (value - min) / (max - min)) gives.
    const double scaled = (value - range.min) / (range.max - range.min) * 0x1p32;
    return scaled >= 0x1p32 ? 0xffffffffU : static_cast<std::uint32_t>(scaled);
}

// Particles that are sorted together: with what sorting needs they fit a core's cache, unless there are more
// than a thousand ranges of them.
constexpr std::uint64_t fewestInRange = std::uint64_t{1} << 15;
constexpr std::uint64_t wantedRanges = 1024;

class Planner {
  public:
    Planner(const std::vector<std::uint32_t>& counts, unsigned gridLevel, const OctreeOptions& options)
        : options_(options) {
        plan_.gridLevel = gridLevel;
        plan_.levels.resize(std::min(gridLevel, options.maxLevel) + 1);
        sums_.resize(gridLevel + 1);
        sums_[gridLevel] = counts;
        for (unsigned level = gridLevel; level-- > 0;) {
            sums_[level].resize(std::size_t{1} << (3 * level));
            for (std::size_t i = 0; i < sums_[level + 1].size(); ++i) {
                sums_[level][i / 8] += sums_[level + 1][i];
            }
        }
    }

    CellPlan plan() {
        visit(0, 0);
        groupUnits();
        mapCells();
        return std::move(plan_);
    }

  private:
    void visit(unsigned level, std::uint64_t morton) {
        const std::uint32_t count = sums_[level][morton];
        auto& nodes = plan_.levels[level];
        const std::size_t index = nodes.size();
        nodes.add(count);
        const bool divided = count > options_.leafCapacity && level < options_.maxLevel;
        if (!divided || level == plan_.gridLevel) {
            plan_.units.push_back({static_cast<std::uint8_t>(level), divided, count,
                                   static_cast<std::uint32_t>(index), morton});
            return;
        }
        for (unsigned child = 0; child < 8; ++child) {
            if (sums_[level + 1][8 * morton + child] == 0) continue;
            plan_.levels[level].children[index] |= static_cast<std::uint8_t>(1U << child);
            visit(level + 1, 8 * morton + child);
        }
    }

    void groupUnits() {
        const std::uint64_t target = std::max(fewestInRange, sums_[0][0] / wantedRanges);
        PlanRange range;
        for (const auto& unit : plan_.units) {
            if (range.unitCount > 0 && range.count + unit.count > target) {
                plan_.ranges.push_back(range);
                range = {range.firstUnit + range.unitCount, 0, range.begin + range.count, 0};
            }
            ++range.unitCount;
            range.count += unit.count;
        }
        plan_.ranges.push_back(range);
        MOTE_CHECK(plan_.ranges.size() < (std::size_t{1} << 16));
    }

    void mapCells() {
        plan_.rangeOfCell.resize(sums_[plan_.gridLevel].size());
        for (std::size_t range = 0; range < plan_.ranges.size(); ++range) {
            for (std::size_t i = 0; i < plan_.ranges[range].unitCount; ++i) {
                const auto& unit = plan_.units[plan_.ranges[range].firstUnit + i];
                const unsigned shift = 3 * (plan_.gridLevel - unit.level);
                const auto first =
                    plan_.rangeOfCell.begin() + static_cast<std::ptrdiff_t>(unit.morton << shift);
                std::fill(first, first + (std::ptrdiff_t{1} << shift), static_cast<std::uint16_t>(range));
            }
        }
    }

    OctreeOptions options_;
    CellPlan plan_;
    std::vector<std::vector<std::uint32_t>> sums_;  ///< by level, by cell
};

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
    MOTE_ASSIGN_OR_RETURN(auto cells, shareValues<std::uint32_t>(ranks, mine.cells));
    const Rest rest{mine.lost, mine.invalid, mine.outside, mine.weight};
    MOTE_ASSIGN_OR_RETURN(const auto rests, shareValues<Rest>(ranks, std::span(&rest, 1)));
    CellCount sum;
    for (std::size_t rank = 0; rank < cells.size(); ++rank) {
        const Rest& other = rests[rank].front();
        sum.add({std::move(cells[rank]), other.lost, other.invalid, other.outside, other.weight});
    }
    return sum;
}

void quantize(const ParticleBlock& block, const std::array<Range, 3>& bounds, QuantizedBlock& result) {
    result.particles.resize(block.size());
    result.weight.resize(block.size());
    std::size_t size = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
        const double x = block.coordinate[0][i];
        const double y = block.coordinate[1][i];
        const double z = block.coordinate[2][i];
        if (!bounds[0].contains(x) || !bounds[1].contains(y) || !bounds[2].contains(z)) continue;
        result.particles[size] = {fraction(bounds[0], x), fraction(bounds[1], y), fraction(bounds[2], z),
                                  block.row[i]};
        result.weight[size] = block.weight[i];
        ++size;
    }
    result.outside = block.size() - size;
    result.particles.resize(size);
    result.weight.resize(size);
}

unsigned gridLevelFor(std::uint64_t rows) {
    constexpr unsigned most = 7;
    unsigned level = 1;
    while (level < most && (rows >> (3 * level)) > 4) ++level;
    return level;
}

CellPlan planCells(const std::vector<std::uint32_t>& counts, unsigned gridLevel,
                   const OctreeOptions& options) {
    return Planner(counts, gridLevel, options).plan();
}

}  // namespace mote::prep
