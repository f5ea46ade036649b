// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/resident_fields.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>

namespace mote::render {
namespace {

std::uint32_t packed(float root, float t) {
    const std::uint32_t high = (std::bit_cast<std::uint32_t>(root) + 0x8000U) & 0xffff0000U;
    return high | static_cast<std::uint32_t>(std::lround(std::clamp(t, 0.0F, 1.0F) * PackedVolume::fullT));
}

float extinctionOf(std::uint32_t word) {
    const float root = std::bit_cast<float>(word & 0xffff0000U);
    return root * root * root;
}

}  // namespace

PackedVolume::PackedVolume(const StepVolume& grid)
    : size_(grid.size), words_(new std::uint32_t[std::size_t{size_.x + 2} * (size_.y + 2) * (size_.z + 2)]) {
    const auto inside = [](std::uint32_t at, std::uint32_t size) { return std::clamp(at, 1U, size) - 1; };
    oneapi::tbb::parallel_for(0U, size_.z + 2, [&](std::uint32_t z) {
        for (std::uint32_t y = 0; y < sheetRows(); ++y) {
            std::uint32_t* const row = &words_[index(0, y, z)];
            const std::size_t from = grid.index(0, inside(y, size_.y), inside(z, size_.z));
            for (std::uint32_t x = 0; x < rowWords(); ++x) {
                const std::size_t cell = from + inside(x, size_.x);
                row[x] = packed(grid.root[cell], grid.t[cell]);
            }
        }
    });
}

/// The range in a block, with the cells beside it.
BlockRanges::Range PackedVolume::rangeOf(const glm::uvec3& block, std::uint32_t edge) const {
    const glm::uvec3 first = block * edge, last = glm::min(first + edge, size_ + 1U);
    BlockRanges::Range range{1e30F, 0.0F};
    for (std::uint32_t z = first.z; z <= last.z; ++z) {
        for (std::uint32_t y = first.y; y <= last.y; ++y) {
            for (std::uint32_t x = first.x; x <= last.x; ++x) {
                const float extinction = extinctionOf(words_[index(x, y, z)]);
                range = {std::min(range.low, extinction), std::max(range.high, extinction)};
            }
        }
    }
    return range;
}

BlockRanges PackedVolume::ranges() const {
    const std::uint32_t edgeBits = std::max({size_.x, size_.y, size_.z}) >= 128 ? 3 : 2;
    const glm::uvec3 count = (size_ >> edgeBits) + 1U;
    std::vector<BlockRanges::Range> ranges(std::size_t{count.x} * count.y * count.z);
    oneapi::tbb::parallel_for(0U, count.z, [&](std::uint32_t z) {
        for (std::uint32_t y = 0; y < count.y; ++y) {
            for (std::uint32_t x = 0; x < count.x; ++x)
                ranges[(std::size_t{z} * count.y + y) * count.x + x] = rangeOf({x, y, z}, 1U << edgeBits);
        }
    });
    return {edgeBits, count, std::move(ranges), {}};
}

std::vector<VisibleField> ResidentFields::of(const FramePlan& plan) {
    std::vector<VisibleField> visible;
    for (const auto& field : plan.fields) {
        if (const auto* const cells = field.density()) {
            const PackedVolume& volume = resident(cells->grid);
            const SeenField seen = seen_.of(field, *cells, [&] { return volume.ranges(); });
            visible.push_back(
                {seen, seen.blocks != nullptr ? &volume : nullptr, static_cast<float>(cells->strength)});
        } else {
            const SeenField seen = seen_.of(field, *field.grid());
            const std::size_t kept = std::max<std::size_t>(plan.fields.size(), 2);
            visible.push_back({.seen = seen, .dark = cellByCell(plan) ? dark(field, seen, kept) : nullptr});
        }
    }
    return visible;
}

std::shared_ptr<const DarkCells> ResidentFields::dark(const FieldPlan& plan, const SeenField& seen,
                                                      std::size_t kept) {
    const CorrectedField& samples = *plan.grid();
    if (seen.blocks == nullptr || !samples.corrected() || samples.mixed()) return nullptr;
    const TransferFunction& transfer = plan.transfer;
    const GridField& field = *samples.grid;
    return dark_.of(samples.grid, {transfer.opacity, transfer.opacityLength, transfer.fade, transfer.span},
                    kept, DarkCells::bytesOf(field),
                    [&] { return DarkCells(field, *seen.table, *seen.blocks); });
}

void ResidentFields::dropExpired() {
    dark_.dropExpired();
    volumes_.remove_if([](const Resident& one) { return one.grid.expired(); });
    seen_.dropExpired();
}

const PackedVolume& ResidentFields::resident(const std::shared_ptr<const StepVolume>& grid) {
    // A new grid may stand at the address of one that is gone: the weak pointers tell them apart.
    for (const auto& one : volumes_) {
        if (one.key == grid.get() && !one.grid.expired()) return one.volume;
    }
    return volumes_.emplace_back(Resident{grid, grid.get(), PackedVolume(*grid)}).volume;
}

}  // namespace mote::render
