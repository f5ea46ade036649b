// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/point_groups.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "protocol/base/most_recent.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"
#include "server/render/plan/tile_lists.h"

namespace mote::render {
namespace {

constexpr std::size_t groupedLeaves = std::size_t{1} << 14;
/// Points of a group, unless they are of one leaf.
constexpr std::uint64_t mostGrouped = 128;
/// Levels between a group and its deepest leaf: a GroupedPoint tells places in so small cells exactly.
constexpr std::uint32_t mostDeeper = 4;
/// Leaves are sorted by parts of the box first, cells of this level.
constexpr std::uint32_t partLevel = 5;
constexpr std::size_t boxParts = std::size_t{1} << (3 * partLevel);

/// The low 16 bits of a number, each followed by two zeros.
std::uint64_t spreadBits(std::uint64_t x) {
    x &= 0xffff;
    x = (x | x << 16) & 0x0000ff0000ffU;
    x = (x | x << 8) & 0x00f00f00f00fU;
    x = (x | x << 4) & 0x0c30c30c30c3U;
    return (x | x << 2) & 0x249249249249U;
}

/// The first cell of the deepest level in a cell, in Morton order.
std::uint64_t firstWithin(LeafCell cell) {
    const std::uint64_t morton =
        spreadBits(cellX(cell)) | spreadBits(cellY(cell)) << 1 | spreadBits(cellZ(cell)) << 2;
    return morton << (3 * (deepestLeafLevel - cellLevel(cell)));
}

/// The cell of a level around another one that is no larger.
LeafCell cellAround(LeafCell cell, std::uint32_t level) {
    const std::uint32_t up = cellLevel(cell) - level;
    return std::uint64_t{cellX(cell) >> up} | std::uint64_t{cellY(cell) >> up} << 16 |
           std::uint64_t{cellZ(cell) >> up} << 32 | std::uint64_t{level} << 48;
}

/// Where a leaf's points lie in the cell of a group.
class InGroup {
  public:
    InGroup(LeafCell leaf, LeafCell group)
        : deeper_(cellLevel(leaf) - cellLevel(group)),
          x_(within(cellX(leaf), cellX(group))),
          y_(within(cellY(leaf), cellY(group))),
          z_(within(cellZ(leaf), cellZ(group))) {}

    GroupedPoint operator()(storage::PackedPosition p) const {
        const std::uint32_t x = place(x_, p.x), y = place(y_, p.y), z = place(z_, p.z);
        return {x | y << 21, z << 11 | y >> 11};
    }

  private:
    std::uint32_t within(std::uint32_t leaf, std::uint32_t group) const {
        return (leaf - (group << deeper_)) << 16;
    }
    /// In the middle of its step.
    std::uint32_t place(std::uint32_t leaf, std::uint32_t position) const {
        return (2 * (leaf | position) + 1) << (mostDeeper - deeper_);
    }

    std::uint32_t deeper_, x_, y_, z_;
};

/// Some leaves of a part that follow each other in Morton order, as a group.
struct MadeGroup {
    LeafCell cell;
    std::size_t leaves;
    std::uint64_t points;
};

/// The leaves of a part, in Morton order, cut into groups.
class PartGroups {
  public:
    explicit PartGroups(std::span<LeafPoints> leaves) : leaves_(leaves), keys_(leaves.size()) {
        std::vector<std::pair<std::uint64_t, std::uint32_t>> order(leaves.size());
        for (std::size_t i = 0; i < leaves.size(); ++i)
            order[i] = {firstWithin(leaves[i].cell), static_cast<std::uint32_t>(i)};
        std::sort(order.begin(), order.end());
        const std::vector<LeafPoints> unsorted(leaves.begin(), leaves.end());
        for (std::size_t i = 0; i < leaves.size(); ++i) {
            keys_[i] = order[i].first;
            leaves_[i] = unsorted[order[i].second];
        }
        cut(0, leaves.size(), partLevel);
    }

    std::vector<MadeGroup> take() { return std::move(made_); }

  private:
    void cut(std::size_t begin, std::size_t end, std::uint32_t level) {
        std::uint64_t points = 0;
        std::uint32_t deepest = 0;
        for (std::size_t i = begin; i < end; ++i) {
            points += leaves_[i].count();
            deepest = std::max(deepest, cellLevel(leaves_[i].cell));
        }
        // Runs of one leaf begin at the same place.
        if (keys_[begin] == keys_[end - 1]) {
            made_.push_back({cellAround(leaves_[begin].cell, deepest), end - begin, points});
        } else if (points <= mostGrouped && deepest <= level + mostDeeper && !alike(begin, end, level)) {
            made_.push_back({cellAround(leaves_[begin].cell, level), end - begin, points});
        } else {
            forEachChild(begin, end, level,
                         [&](std::size_t from, std::size_t to) { cut(from, to, level + 1); });
        }
    }

    std::uint64_t childOf(std::size_t leaf, std::uint32_t level) const {
        return keys_[leaf] >> (3 * (deepestLeafLevel - level - 1));
    }
    /// Whether all leaves lie in one child of their cell.
    bool alike(std::size_t begin, std::size_t end, std::uint32_t level) const {
        return childOf(begin, level) == childOf(end - 1, level);
    }

    template <class Visit>
    void forEachChild(std::size_t begin, std::size_t end, std::uint32_t level, Visit visit) const {
        while (begin < end) {
            std::size_t next = begin + 1;
            while (next < end && childOf(next, level) == childOf(begin, level)) ++next;
            visit(begin, next);
            begin = next;
        }
    }

    std::span<LeafPoints> leaves_;
    std::vector<std::uint64_t> keys_;
    std::vector<MadeGroup> made_;
};

/// The points of one selection on their way into groups.
class Grouping {
  public:
    Grouping(const PointsPlan& layer, std::span<const LeafCell> cells)
        : layer_(layer),
          leaves_(layer.step->leaves()),
          cells_(cells),
          positions_(layer.step->positions(0, 0).data()) {}

    std::shared_ptr<const PointGroups> make(const std::stop_token& stop) {
        byPart_.fill(
            boxParts, (cells_.size() + groupedLeaves - 1) / groupedLeaves, stop,
            [this](std::size_t chunk) { verify(chunk); },
            [this](std::size_t chunk, auto visit) { visitLeaves(chunk, visit); });
        std::vector<std::vector<MadeGroup>> made(boxParts);
        forInTurns(std::size_t{0}, boxParts, [&](std::size_t part) {
            if (const auto leaves = byPart_.of(part); !leaves.empty() && !stop.stop_requested())
                made[part] = PartGroups(leaves).take();
        });
        if (stop.stop_requested()) return nullptr;
        auto groups = std::make_shared<PointGroups>();
        std::uint64_t points = 0;
        std::vector<std::uint64_t> begin(boxParts);
        for (std::size_t part = 0; part < boxParts; ++part) {
            begin[part] = points;
            for (const MadeGroup& group : made[part]) {
                addGroup(group, points, groups->groups);
                points += group.points;
            }
        }
        resizeInTurns(groups->points, points + sparePoints);
        if (shaded()) resizeInTurns(groups->levels, points + sparePoints);
        forInTurns(std::size_t{0}, boxParts, [&](std::size_t part) {
            copyPoints(made[part], byPart_.of(part), groups->points.data() + begin[part]);
            if (shaded()) copyLevels(byPart_.of(part), groups->levels.data() + begin[part]);
        });
        return groups;
    }

  private:
    bool shaded() const { return !layer_.selection->levels.empty(); }
    std::size_t endOf(std::size_t chunk) const {
        return std::min(cells_.size(), (chunk + 1) * groupedLeaves);
    }

    /// Checks that the bytes of a chunk's points are right.
    void verify(std::size_t chunk) const {
        const std::size_t first = chunk * groupedLeaves, end = endOf(chunk);
        const auto& drawn = layer_.selection->drawn;
        if (std::all_of(drawn.begin() + static_cast<std::ptrdiff_t>(first),
                        drawn.begin() + static_cast<std::ptrdiff_t>(end),
                        [](std::uint32_t points) { return points == 0; }))
            return;
        const std::uint64_t begin = leaves_.pointBegin[first];
        layer_.step->positions(begin, leaves_.pointBegin[end - 1] + leaves_.pointCount[end - 1] - begin);
    }

    template <class Visit>
    void visitLeaves(std::size_t chunk, Visit& visit) const {
        for (std::size_t leaf = chunk * groupedLeaves; leaf < endOf(chunk); ++leaf) {
            std::uint64_t begin = leaves_.pointBegin[leaf];
            for (std::uint64_t left = layer_.selection->drawn[leaf]; left > 0;) {
                const std::uint64_t run = std::min(left, LeafPoints::mostPoints);
                visit(static_cast<std::size_t>(firstWithin(cells_[leaf]) >>
                                               (3 * (deepestLeafLevel - partLevel))),
                      LeafPoints::of(cells_[leaf], run, begin, layer_.selection->levelOf(leaf)));
                begin += run;
                left -= run;
            }
        }
    }

    static void addGroup(const MadeGroup& group, std::uint64_t begin, std::vector<LeafPoints>& out) {
        for (std::uint64_t left = group.points; left > 0;) {
            const std::uint64_t run = std::min(left, LeafPoints::mostPoints);
            out.push_back(LeafPoints::of(group.cell, run, begin));
            begin += run;
            left -= run;
        }
    }

    void copyPoints(const std::vector<MadeGroup>& made, std::span<const LeafPoints> leaves,
                    GroupedPoint* out) const {
        constexpr std::size_t ahead = 24;  // leaves: their points lie all over the file
        std::size_t leaf = 0;
        for (const MadeGroup& group : made) {
            for (const std::size_t end = leaf + group.leaves; leaf < end; ++leaf) {
                if (leaf + ahead < leaves.size())
                    __builtin_prefetch(positions_ + leaves[leaf + ahead].begin());
                const InGroup inGroup(leaves[leaf].cell, group.cell);
                const auto* const points = positions_ + leaves[leaf].begin();
                out = std::transform(points, points + leaves[leaf].count(), out, inGroup);
            }
        }
    }

    static void copyLevels(std::span<const LeafPoints> leaves, std::uint8_t* out) {
        for (const LeafPoints& leaf : leaves) out = std::fill_n(out, leaf.count(), leaf.level());
    }

    const PointsPlan& layer_;
    const storage::Leaves leaves_;
    const std::span<const LeafCell> cells_;
    const storage::PackedPosition* const positions_;
    TileLists<LeafPoints> byPart_;
};

}  // namespace

bool PointGroups::serve(const FramePlan& plan, const PointsPlan& layer, const PointMap& map) {
    constexpr double mostPixels = 16384.0;
    const PointSelection& selection = *layer.selection;
    return plan.exact && selection.weights.empty() && selection.points > 0 &&
           selection.points <= mostPoints && map.longestEdge() <= mostPixels;
}

std::shared_ptr<const PointGroups> groupPoints(const PointsPlan& layer, std::span<const LeafCell> cells,
                                               const std::stop_token& stop) {
    return Grouping(layer, cells).make(stop);
}

std::shared_ptr<const PointGroups> ResidentGroups::of(const PointsPlan& layer,
                                                      std::span<const LeafCell> cells,
                                                      const std::stop_token& stop) {
    constexpr std::size_t kept = 4;
    const auto* const known =
        mostRecent(entries_, [&](const Entry& entry) { return entry.selection.lock() == layer.selection; });
    if (known != nullptr) return known->groups;
    dropExpired();
    // They are large: the oldest go before the new ones come.
    std::uint64_t points = layer.selection->points;
    std::size_t left = 0;
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry, ++left) {
        points += entry->groups->points.size();
        if (left + 1 < kept && points <= PointGroups::mostPoints) continue;
        entries_.erase(entry, entries_.end());
        break;
    }
    auto groups = groupPoints(layer, cells, stop);
    if (groups != nullptr) entries_.push_front({layer.selection, groups});
    return groups;
}

void ResidentGroups::dropExpired() {
    entries_.remove_if([](const Entry& entry) { return entry.selection.expired(); });
}

}  // namespace mote::render
