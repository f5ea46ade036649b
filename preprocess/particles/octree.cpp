// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/octree.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

namespace mote::prep {
namespace {

/// A leaf on its way to its place in the file.
struct LeafKey {
    std::uint32_t density;  ///< the bits of the float, which are in its order from 0 on
    std::uint32_t node;
    std::uint64_t morton;
};

/// What stands before each place of a list: sums of numbers, found side by side.
template <class Number>
class SumsBefore {
  public:
    /// `number(i)` of the places [0, size), the same whenever it is asked.
    SumsBefore(std::size_t size, Number number)
        : size_(size), number_(std::move(number)), before_((size + together - 1) / together + 1) {
        forEachBlock([&](std::size_t block, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) before_[block + 1] += number_(i);
        });
        std::inclusive_scan(before_.begin(), before_.end(), before_.begin());
    }

    std::uint64_t total() const { return before_.back(); }

    /// Calls `use(i, sum of the numbers before i)` for each place.
    template <class Use>
    void forEach(const Use& use) const {
        forEachBlock([&](std::size_t block, std::size_t begin, std::size_t end) {
            std::uint64_t sum = before_[block];
            for (std::size_t i = begin; i < end; ++i) {
                use(i, sum);
                sum += number_(i);
            }
        });
    }

  private:
    static constexpr std::size_t together = std::size_t{1} << 13;

    template <class Use>
    void forEachBlock(const Use& use) const {
        tbb::parallel_for(std::size_t{0}, before_.size() - 1, [&](std::size_t block) {
            use(block, block * together, std::min(size_, (block + 1) * together));
        });
    }

    std::size_t size_;
    Number number_;
    std::vector<std::uint64_t> before_;  ///< by block, and one more
};

/// A stable sort by density, the least significant bits first. Digits that are the same everywhere cost a
/// look.
class DensitySort {
  public:
    explicit DensitySort(std::vector<LeafKey>& leaves)
        : leaves_(leaves), other_(leaves.size()), parts_((leaves.size() + together - 1) / together) {}

    void run() {
        for (unsigned shift = 0; shift < bits; shift += digitBits) {
            count(shift);
            if (findPlaces()) move(shift);
        }
    }

  private:
    static constexpr unsigned bits = 32, digitBits = 11;
    static constexpr std::size_t digits = std::size_t{1} << digitBits;
    static constexpr std::size_t together = std::size_t{1} << 17;
    using Places = std::array<std::uint32_t, digits>;

    static std::size_t digitOf(const LeafKey& leaf, unsigned shift) {
        return leaf.density >> shift & (digits - 1);
    }

    template <class Use>
    void forEach(const Use& use) {
        tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t part) {
            const std::size_t begin = part * together;
            use(std::span(leaves_).subspan(begin, std::min(together, leaves_.size() - begin)), parts_[part]);
        });
    }

    void count(unsigned shift) {
        forEach([&](std::span<const LeafKey> leaves, Places& counts) {
            counts.fill(0);
            for (const auto& leaf : leaves) ++counts[digitOf(leaf, shift)];
        });
    }

    /// Makes places of counts; false: there is only one digit, so all are there.
    bool findPlaces() {
        std::uint32_t at = 0;
        for (std::size_t digit = 0; digit < digits; ++digit) {
            const auto before = at;
            for (auto& part : parts_) at += std::exchange(part[digit], at);
            if (before == 0 && at == leaves_.size()) return false;
        }
        return true;
    }

    void move(unsigned shift) {
        forEach([&](std::span<const LeafKey> leaves, Places& places) {
            for (const auto& leaf : leaves) other_[places[digitOf(leaf, shift)]++] = leaf;
        });
        leaves_.swap(other_);
    }

    std::vector<LeafKey>& leaves_;
    std::vector<LeafKey> other_;
    std::vector<Places> parts_;  ///< by part of the leaves, by digit: how many, then where the next one goes
};

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

/// Sorts leaves that are in order by density by Morton key, too, those of one density together.
void sortByKey(std::vector<LeafKey>& leaves) {
    constexpr std::size_t together = std::size_t{1} << 13;
    const auto less = [](const LeafKey& a, const LeafKey& b) { return a.density < b.density; };
    // The first density that begins in a block or behind it: no density is in two blocks.
    std::vector<std::vector<LeafKey>::iterator> first;
    for (std::size_t at = 0; at < leaves.size(); at += together) {
        const auto begin = leaves.begin() + static_cast<std::ptrdiff_t>(at);
        first.push_back(at == 0 ? begin : std::upper_bound(begin - 1, leaves.end(), *(begin - 1), less));
    }
    first.push_back(leaves.end());
    tbb::parallel_for(std::size_t{1}, first.size(), [&](std::size_t block) {
        for (auto begin = first[block - 1]; begin < first[block];) {
            const auto end = std::find_if(
                begin, first[block], [&](const LeafKey& leaf) { return leaf.density != begin->density; });
            mergeRuns(begin, end);
            begin = end;
        }
    });
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
            const auto childrenOf = [&](std::size_t i) {
                return static_cast<std::uint8_t>(std::popcount(level.children[i]));
            };
            SumsBefore(level.size(), childrenOf).forEach([&](std::size_t i, std::uint64_t before) {
                const std::size_t node = first_[depth] + i;
                tree_.firstChild[node] = static_cast<std::uint32_t>(first_[depth + 1] + before);
                tree_.level[node] = static_cast<std::uint8_t>(depth);
                tree_.childCount[node] = childrenOf(i);
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
        const auto isLeaf = [&](std::size_t node) { return std::size_t{tree_.childCount[node] == 0}; };
        const SumsBefore leaves(tree_.level.size(), isLeaf);
        std::vector<LeafKey> keys(leaves.total());
        leaves.forEach([&](std::size_t node, std::uint64_t before) {
            if (isLeaf(node) == 0) return;
            keys[before] = {std::bit_cast<std::uint32_t>(tree_.density[node]),
                            static_cast<std::uint32_t>(node), tree_.morton[node]};
        });
        return keys;
    }

    void orderLeaves() {
        levels_ = {};
        auto keys = leafKeys();
        // By density, then Morton key, then level. They come level by level, each in Morton order.
        DensitySort(keys).run();
        sortByKey(keys);
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
        const SumsBefore points(keys.size(),
                                [&](std::size_t leaf) { return std::uint64_t{tree_.leafPointCount[leaf]}; });
        points.forEach([&](std::size_t leaf, std::uint64_t before) { tree_.leafPointBegin[leaf] = before; });
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
    using Nodes = tbb::blocked_range<std::size_t>;
    std::vector<float> known(tree.density.size());  // by node: the density of the cell that it is told by
    if (!known.empty()) known[0] = tree.density[0];
    const auto look = [&](const Nodes& nodes, Range range) {
        for (auto node = nodes.begin(); node != nodes.end(); ++node) {
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
    };
    Range range;
    // Level by level: what a node is told by, its parent has found.
    for (auto begin = tree.level.begin(); begin != tree.level.end();) {
        const auto end = std::upper_bound(begin, tree.level.end(), *begin);
        const Nodes level(static_cast<std::size_t>(begin - tree.level.begin()),
                          static_cast<std::size_t>(end - tree.level.begin()), std::size_t{1} << 13);
        range = tbb::parallel_reduce(level, range, look,
                                     [](const Range& a, const Range& b) { return a.united(b); });
        begin = end;
    }
    return range;
}

}  // namespace mote::prep
