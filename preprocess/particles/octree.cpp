// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/octree.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace mote::prep {
namespace {

/// Where a node's children begin among the sorted particles; child i has [begin[i], begin[i + 1]).
using Split = std::array<std::uint64_t, 9>;

class Builder {
  public:
    Builder(std::span<const std::uint64_t> keys, std::span<const double> weights, unsigned keyLevel,
            const OctreeOptions& options)
        : keys_(keys), weights_(weights), keyLevel_(keyLevel), options_(options) {}

    Result<Octree> build() {
        addNode(0, 0, 0, keys_.size());
        std::size_t begin = 0;
        for (unsigned level = 0; level < options_.maxLevel; ++level) {
            const std::size_t end = tree_.level.size();
            MOTE_RETURN_IF_ERROR(divideLevel(begin, end, level));
            begin = end;
        }
        sumWeights();
        MOTE_RETURN_IF_ERROR(setDensities());
        orderLeaves();
        return std::move(tree_);
    }

  private:
    void addNode(std::uint8_t level, std::uint64_t morton, std::uint64_t begin, std::uint64_t end) {
        tree_.level.push_back(level);
        tree_.morton.push_back(morton);
        tree_.firstChild.push_back(0);
        tree_.childCount.push_back(0);
        tree_.count.push_back(end - begin);
        source_.push_back(begin);
    }

    Split split(std::size_t node, unsigned level) const {
        const unsigned shift = 3 * (keyLevel_ - level - 1);
        const std::uint64_t begin = source_[node];
        const std::uint64_t end = begin + tree_.count[node];
        Split result{};
        result.front() = begin;
        result.back() = end;
        for (std::uint64_t child = 1; child < 8; ++child) {
            const std::uint64_t first = (tree_.morton[node] * 8 + child) << shift;
            const auto from = keys_.begin() + static_cast<std::ptrdiff_t>(result[child - 1]);
            const auto to = keys_.begin() + static_cast<std::ptrdiff_t>(end);
            result[child] = static_cast<std::uint64_t>(std::lower_bound(from, to, first) - keys_.begin());
        }
        return result;
    }

    Status divideLevel(std::size_t begin, std::size_t end, unsigned level) {
        std::vector<std::size_t> full;
        for (std::size_t node = begin; node < end; ++node) {
            if (tree_.count[node] > options_.leafCapacity) full.push_back(node);
        }
        std::vector<Split> splits(full.size());
        tbb::parallel_for(std::size_t{0}, full.size(),
                          [&](std::size_t i) { splits[i] = split(full[i], level); });
        for (std::size_t i = 0; i < full.size(); ++i) {
            const std::size_t first = tree_.level.size();
            if (first + 8 > std::numeric_limits<std::uint32_t>::max()) {
                return Error{ErrorCode::resourceExhausted, "",
                             "the octree has more than 2^32 nodes; raise the leaf capacity"};
            }
            addChildren(full[i], splits[i], level + 1);
            tree_.firstChild[full[i]] = static_cast<std::uint32_t>(first);
            tree_.childCount[full[i]] = static_cast<std::uint8_t>(tree_.level.size() - first);
        }
        return success();
    }

    void addChildren(std::size_t node, const Split& at, unsigned level) {
        for (std::size_t child = 0; child < 8; ++child) {
            if (at[child] == at[child + 1]) continue;
            addNode(static_cast<std::uint8_t>(level), tree_.morton[node] * 8 + child, at[child],
                    at[child + 1]);
        }
    }

    /// Leaves in the order of their particles, inner nodes in the order of their children.
    void sumWeights() {
        weight_.resize(tree_.level.size());
        tbb::parallel_for(std::size_t{0}, weight_.size(), [&](std::size_t node) {
            if (tree_.childCount[node] != 0) return;
            const auto own = weights_.subspan(source_[node], tree_.count[node]);
            weight_[node] = std::accumulate(own.begin(), own.end(), 0.0);
        });
        for (std::size_t node = weight_.size(); node-- > 0;) {
            if (tree_.childCount[node] == 0) continue;
            const auto first = weight_.begin() + tree_.firstChild[node];
            weight_[node] = std::accumulate(first, first + tree_.childCount[node], 0.0);
        }
        tree_.totalWeight = weight_.front();
    }

    Status setDensities() {
        const std::size_t size = weight_.size();
        tree_.density.resize(size);
        tree_.minDensity.resize(size);
        for (std::size_t node = size; node-- > 0;) {
            const double density = std::ldexp(weight_[node], 3 * tree_.level[node]);
            if (!(density <= std::numeric_limits<float>::max())) {
                return Error{ErrorCode::resourceExhausted, "",
                             "the weights are too large for their densities"};
            }
            tree_.density[node] = static_cast<float>(density);
            tree_.minDensity[node] = tree_.density[node];
            if (tree_.childCount[node] == 0) continue;
            const auto first = tree_.minDensity.begin() + tree_.firstChild[node];
            tree_.minDensity[node] = *std::min_element(first, first + tree_.childCount[node]);
        }
        return success();
    }

    void orderLeaves() {
        for (std::size_t node = 0; node < weight_.size(); ++node) {
            if (tree_.childCount[node] == 0) tree_.leafNode.push_back(static_cast<std::uint32_t>(node));
        }
        tbb::parallel_sort(tree_.leafNode.begin(), tree_.leafNode.end(),
                           [&](std::uint32_t a, std::uint32_t b) {
                               if (tree_.density[a] != tree_.density[b])
                                   return tree_.density[a] < tree_.density[b];
                               if (tree_.morton[a] != tree_.morton[b])
                                   return tree_.morton[a] < tree_.morton[b];
                               return tree_.level[a] < tree_.level[b];
                           });
        std::uint64_t begin = 0;
        for (const auto node : tree_.leafNode) {
            tree_.firstChild[node] = static_cast<std::uint32_t>(tree_.leafPointBegin.size());
            tree_.leafPointBegin.push_back(begin);
            tree_.leafPointCount.push_back(static_cast<std::uint32_t>(tree_.count[node]));
            tree_.leafDensity.push_back(tree_.density[node]);
            tree_.leafSource.push_back(source_[node]);
            begin += tree_.count[node];
        }
    }

    std::span<const std::uint64_t> keys_;
    std::span<const double> weights_;
    unsigned keyLevel_;
    OctreeOptions options_;
    Octree tree_;
    std::vector<std::uint64_t> source_;  ///< by node: its first particle among the sorted ones
    std::vector<double> weight_;         ///< by node
};

}  // namespace

storage::OctreeNodes Octree::nodes() const {
    return {level, morton, firstChild, childCount, count, density, minDensity};
}

storage::Leaves Octree::leaves() const {
    return {leafNode, leafPointBegin, leafPointCount, leafDensity};
}

Result<Octree> buildOctree(std::span<const std::uint64_t> keys, std::span<const double> weights,
                           unsigned keyLevel, const OctreeOptions& options) {
    return Builder(keys, weights, keyLevel, options).build();
}

}  // namespace mote::prep
