// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridPoints: the points of a hybrid volume as they lie on disk, in any of their forms (docs/FORMAT.md):
// 5 bytes each, with a place in a brick of 32^3 samples; or 6 or 9, with a place in the whole error grid of
// one or two bytes a coordinate. A view of bytes that somebody else owns; any thread.
#pragma once

#include <cstdint>
#include <span>

#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {

/// A point as its codes say it.
struct HybridPoint {
    GridSize place{};         ///< the sample of the error grid
    std::uint8_t value = 0;   ///< code of the source's value there
    std::uint8_t error = 0;   ///< code of the error, source minus low-resolution volume
    std::uint8_t normal = 0;  ///< NormalTable
};

struct HybridPoints {
    GridSize grid{};  ///< of the error grid
    /// Points of brick b are brickBegin[b] to brickBegin[b + 1]; bricks x fastest, then y, then z. Empty:
    /// flat.
    std::span<const std::uint64_t> brickBegin;
    /// How far a point's place x + 32 y + 1024 z in its brick is from the one before it there, of the first
    /// from 0: 5 bytes a point.
    std::span<const std::uint16_t> advance;
    std::span<const std::uint8_t> place8;    ///< x, y, z of each: 6 bytes a point
    std::span<const std::uint16_t> place16;  ///< x, y, z of each: 9 bytes a point
    std::span<const std::uint8_t> value, error, normal;

    std::uint64_t size() const { return value.size(); }
    /// Bricks that cover the error grid, x fastest.
    GridSize bricks() const { return bricksOf(grid, pointBrickSide); }

    /// Calls visit(HybridPoint) for each point, brick by brick. In the flat forms, too, they lie in that
    /// order.
    template <class Visit>
    void forEach(const Visit& visit) const {
        if (brickBegin.empty()) return forEachFlat(visit);
        const auto counts = bricks();
        for (std::uint64_t brick = 0; brick + 1 < brickBegin.size(); ++brick) {
            const GridSize at{static_cast<std::uint32_t>(brick % counts[0]),
                              static_cast<std::uint32_t>(brick / counts[0] % counts[1]),
                              static_cast<std::uint32_t>(brick / counts[0] / counts[1])};
            forEachIn(at, brickBegin[brick], brickBegin[brick + 1], visit);
        }
    }

    /// Visits points [begin, end) of the brick with the index `at`; only in the hierarchical form.
    template <class Visit>
    void forEachIn(const GridSize& at, std::uint64_t begin, std::uint64_t end, const Visit& visit) const {
        constexpr std::uint32_t side = pointBrickSide;
        std::uint32_t p = 0;
        for (auto i = begin; i < end; ++i) {
            // Where a file made to harm leads out of the brick, it leads back into it.
            p = (p + advance[i]) % (side * side * side);
            visit(HybridPoint{
                {at[0] * side + p % side, at[1] * side + p / side % side, at[2] * side + p / side / side},
                value[i],
                error[i],
                normal[i]});
        }
    }

  private:
    template <class Visit>
    void forEachFlat(const Visit& visit) const {
        const auto coordinate = [&](std::uint64_t i) -> std::uint32_t {
            return place8.empty() ? place16[i] : place8[i];
        };
        for (std::uint64_t i = 0; i < size(); ++i) {
            visit(HybridPoint{{coordinate(3 * i), coordinate(3 * i + 1), coordinate(3 * i + 2)},
                              value[i],
                              error[i],
                              normal[i]});
        }
    }
};

}  // namespace mote::storage
