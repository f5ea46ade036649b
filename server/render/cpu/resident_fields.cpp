// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/resident_fields.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "storage/storage_error.h"

namespace mote::render {
namespace {

std::uint16_t quantised(double t) {
    constexpr double scale = PackedVolume::full / (1.0 + LogDensity::fade);
    return static_cast<std::uint16_t>(std::lround((t + LogDensity::fade) * scale));
}

std::uint32_t checkedSize(const storage::ParticleStep& step) {
    const std::uint32_t size = step.volumeSize();
    if (size == 0 || size > PackedVolume::mostCells ||
        step.volume().size() != std::size_t{size} * size * size) {
        throw storage::StorageError(
            Error{ErrorCode::corrupt, "/volume/density", "the volume's size is not its shape"});
    }
    return size;
}

/// t of each cell, x fastest.
std::unique_ptr<std::uint16_t[]> quantisedCells(std::span<const float> densities, std::uint32_t size,
                                                const LogDensity& scale) {
    std::unique_ptr<std::uint16_t[]> cells(new std::uint16_t[densities.size()]);
    const std::size_t sheet = std::size_t{size} * size;
    oneapi::tbb::parallel_for(0U, size, [&](std::uint32_t z) {
        for (std::size_t i = z * sheet; i < (z + 1) * sheet; ++i)
            cells[i] = quantised(scale.ofCell(densities[i]));
    });
    return cells;
}

float unpacked(std::uint16_t cell) {
    constexpr double scale = (1.0 + LogDensity::fade) / PackedVolume::full;
    return static_cast<float>(cell * scale - LogDensity::fade);
}

/// The range in a block, with the cells beside it.
BlockRanges::Range rangeOf(const PackedVolume& volume, const glm::uvec3& block, std::uint32_t edge) {
    const glm::uvec3 first = block * edge, last = glm::min(first + edge, volume.size() + 1U);
    std::uint16_t low = PackedVolume::full, high = 0;
    for (std::uint32_t z = first.z; z <= last.z; ++z) {
        for (std::uint32_t y = first.y; y <= last.y; ++y) {
            for (std::uint32_t x = first.x; x <= last.x; ++x) {
                const std::uint16_t cell = volume.cell(x, y, z);
                low = std::min(low, cell);
                high = std::max(high, cell);
            }
        }
    }
    return {unpacked(low), unpacked(high)};
}

}  // namespace

PackedVolume::PackedVolume(const storage::ParticleStep& step) : size_(checkedSize(step)) {
    const auto cells = quantisedCells(step.volume(), size_, step.logDensity());
    words_.reset(new std::uint32_t[std::size_t{size_ + 2} * sheetRows() * rowWords()]);
    const auto inside = [this](std::uint32_t padded) {
        return std::size_t{std::clamp(padded, 1U, size_) - 1};
    };
    oneapi::tbb::parallel_for(0U, size_ + 2, [&](std::uint32_t z) {
        for (std::uint32_t y = 0; y < sheetRows(); ++y) {
            const std::uint16_t* const near = &cells[(inside(z) * size_ + inside(y)) * size_];
            const std::uint16_t* const far = &cells[(inside(z) * size_ + inside(y + 1)) * size_];
            std::uint32_t* const row = &words_[(std::size_t{z} * sheetRows() + y) * rowWords()];
            for (std::uint32_t x = 0; x < rowWords(); ++x)
                row[x] = near[inside(x)] | std::uint32_t{far[inside(x)]} << 16;
        }
    });
}

BlockRanges PackedVolume::ranges() const {
    const std::uint32_t edgeBits = size_ >= 128 ? 3 : 2;
    const std::uint32_t side = (size_ >> edgeBits) + 1;
    std::vector<BlockRanges::Range> ranges(std::size_t{side} * side * side);
    oneapi::tbb::parallel_for(0U, side, [&](std::uint32_t z) {
        for (std::uint32_t y = 0; y < side; ++y) {
            for (std::uint32_t x = 0; x < side; ++x)
                ranges[(std::size_t{z} * side + y) * side + x] = rangeOf(*this, {x, y, z}, 1U << edgeBits);
        }
    });
    return {edgeBits, glm::uvec3(side), std::move(ranges), {}};
}

std::vector<VisibleField> ResidentFields::of(const FramePlan& plan) {
    std::vector<VisibleField> visible;
    for (const auto& field : plan.fields) {
        if (const auto* const cells = field.density()) {
            const PackedVolume& volume = resident(cells->step);
            const SeenField seen = seen_.of(field, cells->step, [&] { return volume.ranges(); });
            visible.push_back({seen, seen.blocks != nullptr ? &volume : nullptr});
        } else {
            visible.push_back({.seen = seen_.of(field, *field.grid())});
        }
    }
    return visible;
}

void ResidentFields::dropExpired() {
    volumes_.remove_if([](const Resident& one) { return one.step.expired(); });
    seen_.dropExpired();
}

const PackedVolume& ResidentFields::resident(const std::shared_ptr<const storage::ParticleStep>& step) {
    // A new step may stand at the address of one that is gone: the weak pointers tell them apart.
    for (const auto& one : volumes_) {
        if (one.key == step.get() && !one.step.expired()) return one.volume;
    }
    return volumes_.emplace_back(Resident{step, step.get(), PackedVolume(*step)}).volume;
}

}  // namespace mote::render
