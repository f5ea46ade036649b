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
    : edgeBits_(ranges.edgeBits()), side_(ranges.side()), distances_(ranges.ranges().size() + 3, farthest) {
    for (std::size_t i = 0; i < ranges.ranges().size(); ++i) {
        const auto& range = ranges.ranges()[i];
        if (!table.visible(range.low, range.high)) continue;
        distances_[i] = 0;
        any_ = true;
    }
    if (!any_) return;
    spread(1);
    spread(-1);
}

/// One of the two passes of a distance transform (Rosenfeld, Pfaltz 1966): each block from the neighbours
/// that come before it in the direction of the pass.
void VisibleBlocks::spread(int direction) {
    const int side = static_cast<int>(side_);
    const auto at = [side](int x, int y, int z) {
        return (static_cast<std::size_t>(z) * side + y) * side + x;
    };
    const auto inside = [side](int i) { return i >= 0 && i < side; };
    for (int k = 0; k < side; ++k) {
        for (int j = 0; j < side; ++j) {
            for (int i = 0; i < side; ++i) {
                const int z = direction > 0 ? k : side - 1 - k, y = direction > 0 ? j : side - 1 - j,
                          x = direction > 0 ? i : side - 1 - i;
                std::uint8_t& distance = distances_[at(x, y, z)];
                for (int n = 0; n < 13 && distance > 1; ++n) {
                    const int dx = direction * (n % 3 - 1), dy = direction * (n / 3 % 3 - 1),
                              dz = direction * (n / 9 - 1);
                    if (!inside(x + dx) || !inside(y + dy) || !inside(z + dz)) continue;
                    const std::uint8_t beside = distances_[at(x + dx, y + dy, z + dz)];
                    if (beside < farthest) distance = std::min<std::uint8_t>(distance, beside + 1);
                }
            }
        }
    }
}

}  // namespace mote::render
