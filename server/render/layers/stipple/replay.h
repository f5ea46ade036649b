// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleReplay: a stipple hierarchy as it is drawn from: which points a wanted density asks for, and where
// these then lie (docs/STIPPLES.md; dissertation 2.2.3, with our selection by removal and replay by prefix).
// Made once for a dataset, immutable, shared by pictures; every function is pure, uses all threads of the
// calling arena and gives the same result on any number of them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "server/render/layers/stipple/packed_moves.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::render {

/// A point that is drawn, and where.
struct PlacedPoint {
    std::uint32_t point = 0;  ///< index in the hierarchy: the same dot from picture to picture
    glm::vec3 position{0};    ///< world units; of the plane not wrapped: it may lie a little outside
};

class StippleReplay {
  public:
    /// `hierarchy` is consistent (checkHierarchy) and no longer needed: moves are kept in a few bytes each.
    explicit StippleReplay(const storage::StippleHierarchy& hierarchy);

    std::size_t size() const { return positions_.size(); }
    /// Before any removal: where the wanted density is looked up.
    const glm::vec3& position(std::size_t point) const { return positions_[point]; }
    /// The surface's normal there, unit length.
    const glm::vec3& normal(std::size_t point) const { return normals_[normals_.size() == 1 ? 0 : point]; }
    /// 0 is removed first.
    std::uint32_t removal(std::size_t point) const { return removal_[point]; }
    /// Bytes that it takes.
    std::size_t bytes() const;
    /// How the moves are kept, and how exactly.
    const PackedMoves& moves() const { return moves_; }

    /// Whether a point is drawn where this share of all points is wanted: `share` is the wanted density
    /// around its first position (points an area) over that of all points, size() / area. 0 draws none, 1
    /// and above all, NaN none; a uniform share draws round(share size()) points.
    bool selects(std::size_t point, float share) const {
        const auto all = static_cast<double>(size());
        return all - 0.5 - removal_[point] < share * all;
    }

    /// A 1 for each point that is drawn, from its wanted share. `shares` has size() entries.
    std::vector<std::uint8_t> select(std::span<const float> shares) const;

    /// The drawn points, in the hierarchy's order, each where its removed neighbours let it go: its moves are
    /// walked in order up to the first whose neighbour is drawn. `drawn` has size() entries.
    std::vector<PlacedPoint> place(std::span<const std::uint8_t> drawn) const;

    /// The same for one point.
    glm::vec3 placed(std::size_t point, std::span<const std::uint8_t> drawn) const;

  private:
    std::vector<glm::vec3> positions_;
    std::vector<glm::vec3> normals_;      ///< one if all are alike
    std::vector<std::uint32_t> removal_;  ///< by point
    std::vector<std::uint32_t> pointOfRemoval_;
    PackedMoves moves_;
};

}  // namespace mote::render
