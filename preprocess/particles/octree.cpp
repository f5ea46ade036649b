// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/octree.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace mote::prep {
namespace {

/// A leaf on its way to its place in the file.
struct LeafKey {
    std::uint32_t density;  ///< the bits of the float, which are in its order from 0 on
    std::uint32_t node;
    std::uint64_t morton;
};

/// A stable sort by density, the least significant bits first. Digits that are the same everywhere cost a
/// look.
void sortByDensity(std::vector<LeafKey>& leaves) {
    constexpr unsigned bits = 32, digitBits = 11;
    constexpr std::uint32_t mask = (1U << digitBits) - 1;
    std::vector<LeafKey> other(leaves.size());
    for (unsigned shift = 0; shift < bits; shift += digitBits) {
        std::array<std::size_t, mask + 1> next{};
        for (const auto& leaf : leaves) ++next[leaf.density >> shift & mask];
        if (next[leaves.front().density >> shift & mask] == leaves.size()) continue;
        std::exclusive_scan(next.begin(), next.end(), next.begin(), std::size_t{0});
        for (const auto& leaf : leaves) other[next[leaf.density >> shift & mask]++] = leaf;
        leaves.swap(other);
    }
}

/// A stable sort by Morton key of what is in order but for a few places: the runs between them are merged.
void mergeRuns(std::vector<LeafKey>::iterator begin, std::vector<LeafKey>::iterator end) {
    const auto less = [](const LeafKey& a, const LeafKey& b) { return a.morton < b.morton; };
    const auto first = std::is_sorted_until(begin, end, less);
    if (first == end) return;
    std::vector runs{begin, first};
    while (runs.back() != end) runs.push_back(std::is_sorted_until(runs.back(), end, less));
    while (runs.size() > 2) {
        std::size_t kept = 1;
        for (std::size_t i = 2; i < runs.size(); i += 2) {
            std::inplace_merge(runs[i - 2], runs[i - 1], runs[i], less);
            runs[kept++] = runs[i];
        }
        if (runs.size() % 2 == 0) runs[kept++] = runs.back();
        runs.resize(kept);
    }
}

class Assembly {
  public:
    explicit Assembly(OctreeLevels levels) : levels_(std::move(levels)) {}

    Result<Octree> run() {
        MOTE_RETURN_IF_ERROR(placeLevels());
        linkNodes();
        MOTE_RETURN_IF_ERROR(weigh());
        orderLeaves();
        return std::move(tree_);
    }

  private:
    template <class Use>
    static void forEach(std::size_t begin, std::size_t end, Use use) {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end, 1 << 13), [&](const auto& part) {
            for (auto i = part.begin(); i < part.end(); ++i) use(i);
        });
    }

    /// Side by side: fresh memory takes longer to come than to fill.
    template <class... Lists>
    static void resizeAll(std::size_t size, Lists&... lists) {
        tbb::parallel_invoke([&] { lists.resize(size); }...);
    }

    Status placeLevels() {
        for (const auto& level : levels_) first_.push_back(first_.back() + level.size());
        const std::size_t size = first_.back();
        if (size > std::numeric_limits<std::uint32_t>::max()) {
            return Error{ErrorCode::resourceExhausted, "",
                         "the octree has more than 2^32 nodes; raise the leaf capacity"};
        }
        resizeAll(size, tree_.level, tree_.morton, tree_.firstChild, tree_.childCount, tree_.count,
                  tree_.density, tree_.minDensity, source_);
        return success();
    }

    /// Children stand side by side, in the order of their parents: each level is in Morton order.
    void linkNodes() {
        for (std::size_t depth = 0; depth < levels_.size(); ++depth) {
            const auto& level = levels_[depth];
            std::size_t child = first_[depth + 1];
            for (std::size_t i = 0; i < level.size(); ++i) {
                const std::size_t node = first_[depth] + i;
                tree_.firstChild[node] = static_cast<std::uint32_t>(child);
                child += static_cast<std::size_t>(std::popcount(level.children[i]));
            }
            forEach(0, level.size(), [&](std::size_t i) {
                const std::size_t node = first_[depth] + i;
                tree_.level[node] = static_cast<std::uint8_t>(depth);
                tree_.childCount[node] = static_cast<std::uint8_t>(std::popcount(level.children[i]));
                tree_.count[node] = level.count[i];
                if (level.children[i] != 0) placeChildren(node, level.children[i], levels_[depth + 1]);
            });
        }
    }

    void placeChildren(std::size_t node, unsigned mask, const OctreeLevel& below) {
        std::size_t child = tree_.firstChild[node];
        std::uint64_t source = source_[node];
        for (unsigned number = 0; number < 8; ++number) {
            if ((mask >> number & 1U) == 0) continue;
            tree_.morton[child] = tree_.morton[node] * 8 + number;
            source_[child] = source;
            source += below.count[child - first_[tree_.level[node] + 1U]];
            ++child;
        }
    }

    /// Finds weights, densities and least densities, from the deepest level up.
    Status weigh() {
        std::atomic<bool> tooLarge{false};
        for (std::size_t depth = levels_.size(); depth-- > 0;) {
            forEach(0, levels_[depth].size(), [&](std::size_t i) {
                if (!weighNode(depth, i)) tooLarge.store(true, std::memory_order_relaxed);
            });
        }
        tree_.totalWeight = levels_[0].weight[0];
        if (!tooLarge) return success();
        return Error{ErrorCode::resourceExhausted, "", "the weights are too large for their densities"};
    }

    bool weighNode(std::size_t depth, std::size_t i) {
        const std::size_t node = first_[depth] + i;
        double& weight = levels_[depth].weight[i];
        float least = std::numeric_limits<float>::infinity();
        for (std::size_t k = 0; k < tree_.childCount[node]; ++k) {
            const std::size_t child = tree_.firstChild[node] + k;
            weight += levels_[depth + 1].weight[child - first_[depth + 1]];
            least = std::min(least, tree_.minDensity[child]);
        }
        const double density = std::ldexp(weight, static_cast<int>(3 * depth));
        tree_.density[node] = static_cast<float>(density);
        tree_.minDensity[node] = tree_.childCount[node] == 0 ? tree_.density[node] : least;
        return density <= std::numeric_limits<float>::max();
    }

    std::vector<LeafKey> leafKeys() const {
        std::vector<LeafKey> keys;
        keys.reserve(static_cast<std::size_t>(
            std::count(tree_.childCount.begin(), tree_.childCount.end(), std::uint8_t{0})));
        for (std::size_t node = 0; node < tree_.level.size(); ++node) {
            if (tree_.childCount[node] != 0) continue;
            keys.push_back({std::bit_cast<std::uint32_t>(tree_.density[node]),
                            static_cast<std::uint32_t>(node), tree_.morton[node]});
        }
        return keys;
    }

    void orderLeaves() {
        levels_ = {};
        auto keys = leafKeys();
        // By density, then Morton key, then level. They come level by level, each in Morton order.
        sortByDensity(keys);
        for (auto begin = keys.begin(); begin != keys.end();) {
            const auto end = std::find_if(
                begin, keys.end(), [&](const LeafKey& leaf) { return leaf.density != begin->density; });
            mergeRuns(begin, end);
            begin = end;
        }
        resizeAll(keys.size(), tree_.leafNode, tree_.leafPointBegin, tree_.leafPointCount, tree_.leafDensity,
                  tree_.leafSource);
        forEach(0, keys.size(), [&](std::size_t leaf) {
            const auto node = keys[leaf].node;
            tree_.firstChild[node] = static_cast<std::uint32_t>(leaf);
            tree_.leafNode[leaf] = node;
            tree_.leafPointCount[leaf] = static_cast<std::uint32_t>(tree_.count[node]);
            tree_.leafDensity[leaf] = tree_.density[node];
            tree_.leafSource[leaf] = source_[node];
        });
        std::uint64_t begin = 0;
        for (std::size_t leaf = 0; leaf < keys.size(); ++leaf) {
            tree_.leafPointBegin[leaf] = begin;
            begin += tree_.leafPointCount[leaf];
        }
    }

    OctreeLevels levels_;
    Octree tree_;
    std::vector<std::size_t> first_{0};  ///< by level: its first node
    std::vector<std::uint64_t> source_;  ///< by node: its first particle in Morton order
};

}  // namespace

storage::OctreeNodes Octree::nodes() const {
    return {level, morton, firstChild, childCount, count, density, minDensity};
}

storage::Leaves Octree::leaves() const {
    return {leafNode, leafPointBegin, leafPointCount, leafDensity};
}

Result<Octree> assembleOctree(OctreeLevels levels) {
    return Assembly(std::move(levels)).run();
}

Range densityRange(const Octree& tree) {
    Range range;
    std::vector<float> known(tree.density.size());  // by node: the density of the cell that it is told by
    if (!known.empty()) known[0] = tree.density[0];
    for (std::size_t node = 0; node < known.size(); ++node) {
        for (std::size_t k = 0; k < tree.childCount[node]; ++k) {
            const std::size_t child = tree.firstChild[node] + k;
            known[child] = tree.count[child] >= counted ? tree.density[child] : known[node];
        }
        if (tree.childCount[node] == 0 && tree.density[node] > 0.0F) {
            const double density = known[node] > 0.0F ? known[node] : tree.density[node];
            range = range.united({density, density});
        }
    }
    return range;
}

}  // namespace mote::prep
