// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/leaf_cells.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <string>

#include "server/render/plan/octree_cell.h"
#include "storage/storage_error.h"

namespace mote::render {
namespace {

constexpr std::size_t blockLeaves = std::size_t{1} << 13;

LeafCell cellOf(const storage::OctreeNodes& nodes, std::uint32_t node, std::size_t leaf) {
    if (node >= nodes.size() || nodes.level[node] > deepestLeafLevel) {
        throw storage::StorageError(Error{ErrorCode::corrupt, "/leaves/node[" + std::to_string(leaf) + "]",
                                          "refers to a node that is not there, or deeper than level 16"});
    }
    const std::uint64_t morton = nodes.morton[node];
    return std::uint64_t{everyThirdBit(morton)} | std::uint64_t{everyThirdBit(morton >> 1)} << 16 |
           std::uint64_t{everyThirdBit(morton >> 2)} << 32 | std::uint64_t{nodes.level[node]} << 48;
}

}  // namespace

std::span<const LeafCell> LeafCells::upTo(const storage::ParticleStep& step, std::size_t count) {
    if (count > cells_.size()) {
        const std::size_t known = cells_.size();
        const auto nodes = step.nodes();
        const auto leaves = step.leaves();
        // Once for all, so that what somebody reads stays where it is.
        cells_.reserve(leaves.size());
        std::vector<LeafCell> more(count - known);
        tbb::parallel_for(tbb::blocked_range<std::size_t>(known, count, blockLeaves), [&](const auto& block) {
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                more[i - known] = cellOf(nodes, leaves.node[i], i);
        });
        cells_.insert(cells_.end(), more.begin(), more.end());
    }
    return {cells_.data(), count};
}

LeafCells& ResidentLeaves::of(const std::shared_ptr<const storage::ParticleStep>& step) {
    for (auto& entry : entries_) {
        if (entry.step.lock() == step) return entry.cells;
    }
    entries_.push_back({step, {}});
    return entries_.back().cells;
}

void ResidentLeaves::dropExpired() {
    entries_.remove_if([](const Entry& entry) { return entry.step.expired(); });
}

}  // namespace mote::render
