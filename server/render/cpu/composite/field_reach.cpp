// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite/field_reach.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "server/render/plan/screen_map.h"

namespace mote::render {
namespace {

// Rays are told in single precision: so much farther may they see, pixels and slabs.
constexpr float pixelMargin = 1.0F, slabMargin = 1.0F / 16.0F;

}  // namespace

/// A corner of blocks.
struct FieldReach::Corner {
    float x, y, slab;  ///< pixels; of the picture's slabs
};

/// What lies around corners.
struct FieldReach::Around {
    Corner low{std::numeric_limits<float>::max(), std::numeric_limits<float>::max(),
               std::numeric_limits<float>::max()};
    Corner high{std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest(),
                std::numeric_limits<float>::lowest()};

    void add(const Corner& corner) {
        low = {std::min(low.x, corner.x), std::min(low.y, corner.y), std::min(low.slab, corner.slab)};
        high = {std::max(high.x, corner.x), std::max(high.y, corner.y), std::max(high.slab, corner.slab)};
    }
};

FieldReach::FieldReach(const FramePlan& plan, const std::vector<VisibleField>& visible)
    : columns_(tilesAcross(plan.width)),
      rows_(tilesAcross(plan.height)),
      tiles_(std::size_t{columns_} * rows_, {std::numeric_limits<std::uint32_t>::max(), 0}) {
    for (std::size_t i = 0; i < visible.size(); ++i) {
        if (visible[i].seen.blocks == nullptr) continue;
        if (visible[i].volume == nullptr) {
            addEverywhere(plan.slabs);
        } else {
            add(plan, plan.fields[i].boxToEye, visible[i]);
        }
    }
}

void FieldReach::addEverywhere(std::uint32_t slabs) {
    std::fill(tiles_.begin(), tiles_.end(), Slabs{0, slabs});
}

void FieldReach::add(const FramePlan& plan, const glm::dmat4& boxToEye, const VisibleField& field) {
    const VisibleBlocks& blocks = *field.seen.blocks;
    const glm::dmat4 toScreen = boxToScreen(plan, boxToEye);
    const glm::uvec3 count = blocks.count(), corners = count + 1U;
    const glm::dvec3 size(field.volume->size());
    // Blocks are of padded cells, whose first centre lies half a cell before the box.
    const auto inBox = [&](std::uint32_t block, int axis) {
        return std::clamp((static_cast<double>(block << blocks.edgeBits()) - 0.5) / size[axis], 0.0, 1.0);
    };
    std::vector<Corner> at;
    at.reserve(std::size_t{corners.x} * corners.y * corners.z);
    for (std::uint32_t z = 0; z < corners.z; ++z) {
        for (std::uint32_t y = 0; y < corners.y; ++y) {
            const glm::dvec4 box(0.0, inBox(y, 1), inBox(z, 2), 1.0);
            const glm::dvec4 row = toScreen * box;
            const double deep = -(boxToEye * box).z;
            for (std::uint32_t x = 0; x < corners.x; ++x) {
                const double along = inBox(x, 0);
                const glm::dvec4 screen = row + along * toScreen[0];
                if (!(screen.w > 0.0)) return addEverywhere(plan.slabs);
                const double one = 1.0 / screen.w;
                at.push_back({static_cast<float>(screen.x * one), static_cast<float>(screen.y * one),
                              static_cast<float>(slabOf(plan.sections, deep - along * boxToEye[0].z))});
            }
        }
    }
    const auto corner = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) -> const Corner& {
        return at[(std::size_t{z} * corners.y + y) * corners.x + x];
    };
    const std::uint8_t* steps = blocks.steps();
    for (std::uint32_t z = 0; z < count.z; ++z) {
        for (std::uint32_t y = 0; y < count.y; ++y) {
            for (std::uint32_t x = 0; x < count.x; ++x, ++steps) {
                if (*steps < VisibleBlocks::visible) continue;
                Around around;
                for (std::uint32_t i = 0; i < 8; ++i)
                    around.add(corner(x + (i & 1U), y + (i >> 1 & 1U), z + (i >> 2)));
                addBlock(around, plan.slabs);
            }
        }
    }
}

void FieldReach::addBlock(const Around& around, std::uint32_t slabs) {
    const auto tiles = [](float low, float high, std::uint32_t across) {
        const auto bound = [&](float pixel, float more) {
            return static_cast<std::uint32_t>(
                std::clamp(std::floor(pixel / Tile::edge) + more, 0.0F, static_cast<float>(across)));
        };
        return std::pair(bound(low - pixelMargin, 0.0F), bound(high + pixelMargin, 1.0F));
    };
    const auto [left, right] = tiles(around.low.x, around.high.x, columns_);
    const auto [top, bottom] = tiles(around.low.y, around.high.y, rows_);
    const auto slab = [&](float at) {
        return static_cast<std::uint32_t>(std::clamp(at, 0.0F, static_cast<float>(slabs)));
    };
    const Slabs reached{slab(std::floor(around.low.slab - slabMargin)),
                        slab(std::ceil(around.high.slab + slabMargin))};
    for (std::uint32_t row = top; row < bottom; ++row) {
        for (std::uint32_t column = left; column < right; ++column) {
            Slabs& tile = tiles_[std::size_t{row} * columns_ + column];
            tile = {std::min(tile.first, reached.first), std::max(tile.end, reached.end)};
        }
    }
}

}  // namespace mote::render
