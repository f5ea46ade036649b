// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/octree_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mote::storage {
namespace {

Error corruptAt(const char* array, std::size_t index, const char* message) {
    return {ErrorCode::corrupt, fmt::format("{}[{}]", array, index), message};
}

bool isDensity(float value) {
    return std::isfinite(value) && value >= 0.0F;
}

Status checkNode(const OctreeNodes& nodes, std::size_t i, std::uint32_t maxLevel) {
    if (nodes.level[i] > maxLevel) return corruptAt("/octree/level", i, "is deeper than the octree may be");
    if (nodes.morton[i] >> (3 * nodes.level[i]) != 0) {
        return corruptAt("/octree/morton", i, "is not a cell of its level");
    }
    if (!isDensity(nodes.density[i])) return corruptAt("/octree/density", i, "is not a density");
    return success();
}

Status checkInner(const OctreeNodes& nodes, std::size_t i) {
    std::uint64_t count = 0;
    float least = INFINITY;
    const std::size_t first = nodes.firstChild[i];
    for (std::size_t child = first; child < first + nodes.childCount[i]; ++child) {
        if (nodes.level[child] != nodes.level[i] + 1)
            return corruptAt("/octree/level", child, "skips a level");
        if (nodes.morton[child] >> 3 != nodes.morton[i]) {
            return corruptAt("/octree/morton", child, "does not lie in its parent");
        }
        if (child > first && nodes.morton[child] <= nodes.morton[child - 1]) {
            return corruptAt("/octree/morton", child, "is not in Morton order");
        }
        if (nodes.count[child] > nodes.count[i])
            return corruptAt("/octree/count", child, "exceeds its parent's");
        count += nodes.count[child];
        least = std::min(least, nodes.minDensity[child]);
    }
    if (count != nodes.count[i]) return corruptAt("/octree/count", i, "is not the sum of its children");
    if (least != nodes.minDensity[i])
        return corruptAt("/octree/min_density", i, "is not its children's least");
    return success();
}

Status checkLeaf(const OctreeNodes& nodes, const Leaves& leaves, std::size_t i) {
    const std::size_t leaf = nodes.firstChild[i];
    if (leaf >= leaves.size() || leaves.node[leaf] != i) {
        return corruptAt("/octree/first_child", i, "does not name this node's leaf");
    }
    if (nodes.count[i] != leaves.pointCount[leaf]) return corruptAt("/octree/count", i, "is not its leaf's");
    if (nodes.minDensity[i] != leaves.density[leaf] || nodes.density[i] != leaves.density[leaf]) {
        return corruptAt("/octree/density", i, "is not its leaf's");
    }
    return success();
}

Status checkNodes(const OctreeNodes& nodes, const Leaves& leaves, std::uint32_t maxLevel) {
    const std::size_t size = nodes.size();
    if (size == 0 || nodes.level[0] != 0) return corruptAt("/octree/level", 0, "is not a root");
    // Levels, cells and densities first: what follows compares children with their parents.
    for (std::size_t i = 0; i < size; ++i) MOTE_RETURN_IF_ERROR(checkNode(nodes, i, maxLevel));
    // Breadth first, so each inner node's children begin where those of the one before it ended: this alone
    // makes it one tree, without cycles and without nodes that nobody reaches.
    std::size_t next = 1;
    for (std::size_t i = 0; i < size; ++i) {
        if (nodes.childCount[i] == 0) {
            MOTE_RETURN_IF_ERROR(checkLeaf(nodes, leaves, i));
            continue;
        }
        if (nodes.childCount[i] > 8 || next <= i || nodes.firstChild[i] != next ||
            nodes.childCount[i] > size - next) {
            return corruptAt("/octree/first_child", i, "is out of order");
        }
        MOTE_RETURN_IF_ERROR(checkInner(nodes, i));
        next += nodes.childCount[i];
    }
    if (next != size) return corruptAt("/octree/child_count", 0, "some nodes have no parent");
    return success();
}

Status checkLeaves(const OctreeNodes& nodes, const Leaves& leaves, std::uint64_t points) {
    std::uint64_t begin = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        if (leaves.node[i] >= nodes.size() || nodes.childCount[leaves.node[i]] != 0 ||
            nodes.firstChild[leaves.node[i]] != i) {
            return corruptAt("/leaves/node", i, "does not name this leaf's node");
        }
        if (leaves.pointBegin[i] != begin)
            return corruptAt("/leaves/point_begin", i, "leaves a gap or overlaps");
        if (leaves.pointCount[i] > points - begin)
            return corruptAt("/leaves/point_count", i, "exceeds the points");
        if (leaves.pointCount[i] == 0 && points != 0) return corruptAt("/leaves/point_count", i, "is zero");
        begin += leaves.pointCount[i];
        if (!isDensity(leaves.density[i])) return corruptAt("/leaves/density", i, "is not a density");
        if (i > 0 && leaves.density[i] < leaves.density[i - 1]) {
            return corruptAt("/leaves/density", i, "is not in ascending order");
        }
    }
    if (begin != points) return corruptAt("/leaves/point_count", leaves.size(), "some points lie in no leaf");
    return success();
}

}  // namespace

Status checkOctree(const OctreeNodes& nodes, const Leaves& leaves, std::uint64_t points,
                   std::uint32_t maxLevel) {
    MOTE_RETURN_IF_ERROR(checkLeaves(nodes, leaves, points));
    return checkNodes(nodes, leaves, maxLevel);
}

}  // namespace mote::storage
