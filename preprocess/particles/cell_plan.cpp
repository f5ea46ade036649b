// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/cell_plan.h"

#include <algorithm>

#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

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

unsigned gridLevelFor(std::uint64_t rows) {
    constexpr unsigned most = 7;
    unsigned level = 1;
    while (level < most && (rows >> (3 * level)) > 4) ++level;
    return level;
}

std::uint64_t CellPlan::largestRange() const {
    const auto largest = std::max_element(ranges.begin(), ranges.end(),
                                          [](const auto& a, const auto& b) { return a.count < b.count; });
    return largest->count;
}

CellPlan planCells(const std::vector<std::uint32_t>& counts, unsigned gridLevel,
                   const OctreeOptions& options) {
    return Planner(counts, gridLevel, options).plan();
}

}  // namespace mote::prep
