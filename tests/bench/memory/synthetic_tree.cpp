// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/memory/synthetic_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "server/render/plan/octree_cell.h"

namespace mote::bench {
namespace {

std::array<std::uint32_t, 3> placeOf(std::uint64_t morton) {
    const auto place = render::cellPlace(morton);
    return {place.x, place.y, place.z};
}

}  // namespace

SyntheticTree::SyntheticTree(std::uint64_t points, std::uint64_t seed) {
    const CellMass mass(maxLevel);
    add(0, 0, points);
    for (std::size_t node = 0; node < level.size(); ++node) divide(node, mass, seed);
    sortLeaves();
    findLeast();
}

void SyntheticTree::add(std::uint8_t nodeLevel, std::uint64_t code, std::uint64_t particles) {
    level.push_back(nodeLevel);
    morton.push_back(code);
    firstChild.push_back(0);
    childCount.push_back(0);
    count.push_back(particles);
    density.push_back(static_cast<float>(std::ldexp(static_cast<double>(particles), 3 * nodeLevel)));
    minDensity.push_back(density.back());
}

/// A child gets what the masses up to it make, less what those before it got; rounded by chance, so that the
/// thin halo is not all in the first child.
void SyntheticTree::divide(std::size_t node, const CellMass& mass, std::uint64_t seed) {
    if (count[node] <= leafCapacity || level[node] == maxLevel) return;
    const auto below = static_cast<std::uint8_t>(level[node] + 1);
    std::array<double, 8> share{};
    for (std::uint64_t child = 0; child < 8; ++child) {
        share[child] = mass(below, placeOf(morton[node] << 3 | child));
    }
    const double total = std::accumulate(share.begin(), share.end(), 0.0);
    const double chance = std::ldexp(static_cast<double>(mixed(seed ^ mixed(node)) >> 11), -53);
    firstChild[node] = static_cast<std::uint32_t>(level.size());
    const std::uint64_t all = count[node];
    std::uint64_t given = 0;
    double sum = 0.0;
    for (std::uint64_t child = 0; child < 8; ++child) {
        sum += share[child];
        const double wanted = std::floor(static_cast<double>(all) * sum / total + chance);
        const auto upTo = child == 7 ? all : std::min(all, static_cast<std::uint64_t>(wanted));
        if (upTo > given) {
            add(below, morton[node] << 3 | child, upTo - given);
            ++childCount[node];
        }
        given = std::max(given, upTo);
    }
}

void SyntheticTree::sortLeaves() {
    for (std::size_t node = 0; node < level.size(); ++node) {
        if (childCount[node] == 0) leafNode.push_back(static_cast<std::uint32_t>(node));
    }
    const auto key = [&](std::uint32_t node) {
        return std::tuple(density[node], morton[node] << (3 * (maxLevel - level[node])), level[node]);
    };
    std::sort(leafNode.begin(), leafNode.end(), [&](auto a, auto b) { return key(a) < key(b); });
    std::uint64_t begin = 0;
    for (std::uint32_t leaf = 0; leaf < leafNode.size(); ++leaf) {
        const std::uint32_t node = leafNode[leaf];
        firstChild[node] = leaf;
        leafBegin.push_back(begin);
        leafCount.push_back(static_cast<std::uint32_t>(count[node]));
        leafDensity.push_back(density[node]);
        begin += count[node];
    }
}

void SyntheticTree::findLeast() {
    for (std::size_t node = level.size(); node-- > 0;) {
        if (childCount[node] == 0) continue;
        const auto first = minDensity.begin() + firstChild[node];
        minDensity[node] = *std::min_element(first, first + childCount[node]);
    }
}

storage::OctreeNodes SyntheticTree::nodes() const {
    return {level, morton, firstChild, childCount, count, density, minDensity};
}

storage::Leaves SyntheticTree::leaves() const {
    return {leafNode, leafBegin, leafCount, leafDensity};
}

}  // namespace mote::bench
