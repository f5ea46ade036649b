// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/volume_blocks.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include "protocol/scene/log_density.h"

namespace mote::render {
namespace {

float unpacked(std::uint16_t cell) {
    constexpr double scale = (1.0 + LogDensity::fade) / PackedVolume::full;
    return static_cast<float>(cell * scale - LogDensity::fade);
}

/// One of the two passes of a distance transform (Rosenfeld, Pfaltz 1966): each block from the neighbours
/// that come before it in the direction of the pass.
void spread(std::vector<std::uint8_t>& steps, int side, int direction) {
    const auto at = [side](int x, int y, int z) {
        return (static_cast<std::size_t>(z) * side + y) * side + x;
    };
    const auto inside = [side](int i) { return i >= 0 && i < side; };
    const auto ordered = [=](int i) { return direction > 0 ? i : side - 1 - i; };
    for (int i = 0; i < side * side * side; ++i) {
        const int x = ordered(i % side), y = ordered(i / side % side), z = ordered(i / side / side);
        std::uint8_t& here = steps[at(x, y, z)];
        for (int n = 0; n < 13 && here > 1; ++n) {
            const int dx = direction * (n % 3 - 1), dy = direction * (n / 3 % 3 - 1),
                      dz = direction * (n / 9 - 1);
            if (!inside(x + dx) || !inside(y + dy) || !inside(z + dz)) continue;
            const int beside = steps[at(x + dx, y + dy, z + dz)] + 1;
            if (beside < here) here = static_cast<std::uint8_t>(beside);
        }
    }
}

/// Of each block the steps to the next that is `wanted`, at most VisibleBlocks::farthest.
std::vector<std::uint8_t> stepsTo(const std::vector<std::uint8_t>& blocks, std::uint8_t wanted,
                                  std::uint32_t side) {
    std::vector<std::uint8_t> steps;
    for (const auto block : blocks) steps.push_back(block == wanted ? 0 : VisibleBlocks::farthest);
    spread(steps, static_cast<int>(side), 1);
    spread(steps, static_cast<int>(side), -1);
    return steps;
}

}  // namespace

BlockRanges::BlockRanges(const PackedVolume& volume)
    : edgeBits_(volume.size() >= 128 ? 3 : 2), side_((volume.size() >> edgeBits_) + 1) {
    ranges_.resize(std::size_t{side_} * side_ * side_);
    const std::uint32_t edge = 1U << edgeBits_;
    const std::uint32_t last = volume.size() + 1;
    oneapi::tbb::parallel_for(0U, side_, [&](std::uint32_t bz) {
        for (std::uint32_t by = 0; by < side_; ++by) {
            for (std::uint32_t bx = 0; bx < side_; ++bx) {
                std::uint16_t low = PackedVolume::full, high = 0;
                for (std::uint32_t z = bz * edge; z <= std::min(last, (bz + 1) * edge); ++z) {
                    for (std::uint32_t y = by * edge; y <= std::min(last, (by + 1) * edge); ++y) {
                        for (std::uint32_t x = bx * edge; x <= std::min(last, (bx + 1) * edge); ++x) {
                            const std::uint16_t cell = volume.cell(x, y, z);
                            low = std::min(low, cell);
                            high = std::max(high, cell);
                        }
                    }
                }
                ranges_[(std::size_t{bz} * side_ + by) * side_ + bx] = {unpacked(low), unpacked(high)};
            }
        }
    });
}

VisibleBlocks::VisibleBlocks(const BlockRanges& ranges, const VolumeTable& table)
    : edgeBits_(ranges.edgeBits()), side_(ranges.side()) {
    std::vector<std::uint8_t> seen;
    for (const auto& range : ranges.ranges()) seen.push_back(table.visible(range.low, range.high) ? 1 : 0);
    any_ = std::find(seen.begin(), seen.end(), 1) != seen.end();
    steps_ = stepsTo(seen, 1, side_);
    const auto inside = stepsTo(seen, 0, side_);
    for (std::size_t i = 0; i < seen.size(); ++i) {
        if (seen[i] != 0) steps_[i] = visible + inside[i];
    }
    steps_.resize(steps_.size() + 3);
}

}  // namespace mote::render
