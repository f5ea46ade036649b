// SPDX-License-Identifier: GPL-3.0-or-later
//
// FieldReach: the slabs in which fields may show anything in a tile, told from the projections of their
// visible blocks. Before and behind, points alone are in the picture, whose order does not matter among
// themselves. A value, made once a picture; read by any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/cpu/resident_fields.h"
#include "server/render/cpu/tile.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

class FieldReach {
  public:
    /// [first, end) of the picture's slabs; empty where nothing of any field is seen.
    struct Slabs {
        std::uint32_t first, end;
        bool empty() const { return first >= end; }
        bool holds(std::uint32_t slab) const { return slab >= first && slab < end; }
    };

    /// Of fields of densities alone; of others, and of what reaches behind the eye, all slabs of all tiles.
    FieldReach(const FramePlan& plan, const std::vector<VisibleField>& visible);

    Slabs of(Tile tile) const { return tiles_[std::size_t{tile.row} * columns_ + tile.column]; }

  private:
    struct Corner;
    struct Around;
    void add(const FramePlan& plan, const glm::dmat4& boxToEye, const VisibleField& field);
    void addEverywhere(std::uint32_t slabs);
    void addBlock(const Around& around, std::uint32_t slabs);

    std::uint32_t columns_, rows_;
    std::vector<Slabs> tiles_;  // row by row
};

}  // namespace mote::render
