// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/field_blocks.h"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>

namespace mote::render {
namespace {

/// One of the two passes of a distance transform (Rosenfeld, Pfaltz 1966): each block from the neighbours
/// that come before it in the direction of the pass.
void spread(std::vector<std::uint8_t>& steps, const glm::ivec3& count, int direction) {
    const auto ordered = [=](int i, int side) { return direction > 0 ? i : side - 1 - i; };
    const auto inside = [](int i, int side) { return i >= 0 && i < side; };
    const auto relax = [&](int x, int y, int z) {
        std::uint8_t& here = steps[(static_cast<std::size_t>(z) * count.y + y) * count.x + x];
        for (int n = 0; n < 13 && here > 1; ++n) {
            const int nx = x + direction * (n % 3 - 1), ny = y + direction * (n / 3 % 3 - 1),
                      nz = z + direction * (n / 9 - 1);
            if (!inside(nx, count.x) || !inside(ny, count.y) || !inside(nz, count.z)) continue;
            const int beside = steps[(static_cast<std::size_t>(nz) * count.y + ny) * count.x + nx] + 1;
            if (beside < here) here = static_cast<std::uint8_t>(beside);
        }
    };
    for (int z = 0; z < count.z; ++z) {
        for (int y = 0; y < count.y; ++y) {
            for (int x = 0; x < count.x; ++x)
                relax(ordered(x, count.x), ordered(y, count.y), ordered(z, count.z));
        }
    }
}

/// Gives each block of one kind the steps to the next of another, at most VisibleBlocks::farthest.
void addStepsOut(const std::vector<std::uint8_t>& kinds, std::uint8_t kind, const glm::uvec3& count,
                 std::vector<std::uint8_t>& sum) {
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) return;
    std::vector<std::uint8_t> steps;
    steps.reserve(kinds.size());
    for (const auto one : kinds) steps.push_back(one == kind ? VisibleBlocks::farthest : 0);
    spread(steps, glm::ivec3(count), 1);
    spread(steps, glm::ivec3(count), -1);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        if (kinds[i] == kind) sum[i] = static_cast<std::uint8_t>(kind + steps[i]);
    }
}

}  // namespace

VisibleBlocks::VisibleBlocks(const BlockRanges& ranges, const TransferTable& table)
    : VisibleBlocks(ranges, [&](const auto& range) { return table.visible(range.low, range.high); }) {}

VisibleBlocks::VisibleBlocks(const BlockRanges& ranges,
                             const std::function<bool(const BlockRanges::Range&)>& isSeen)
    : edgeBits_(ranges.edgeBits()), count_(ranges.count()) {
    std::vector<std::uint8_t> kinds;
    kinds.reserve(ranges.ranges().size());
    for (const auto& range : ranges.ranges()) {
        const bool seen = isSeen(range);
        const bool isFine = ranges.fine(kinds.size());
        kinds.push_back(!seen ? std::uint8_t{0} : isFine ? fine : visible);
        any_ = any_ || seen;
        anyFine_ = anyFine_ || (seen && isFine);
    }
    steps_.resize(kinds.size());
    oneapi::tbb::parallel_invoke([&] { addStepsOut(kinds, 0, count_, steps_); },
                                 [&] { addStepsOut(kinds, visible, count_, steps_); },
                                 [&] { addStepsOut(kinds, fine, count_, steps_); });
    steps_.resize(steps_.size() + 3);
}

}  // namespace mote::render
