// SPDX-License-Identifier: GPL-3.0-or-later
//
// The composite of a tile: volumes, points and dots, front to back (docs/PICTURE.md, docs/RENDERING.md), by
// the widest vectors that the processor has. Pure functions, safe on any number of threads.
#pragma once

#include <cstdint>
#include <span>

#include "server/render/cpu/composite/composite_frame.h"
#include "server/render/cpu/tile.h"
#include "server/render/cpu/tile_cells.h"
#include "server/render/cpu/tile_dots.h"

namespace mote::render {

/// Writes the pixels of a tile that lie in the picture. `points`: of each layer, with as many slabs as the
/// frame, or empty where no layer has any here. `dots`: null where there are none. `picture`: the first pixel
/// of the whole picture.
void compositeTile(const CompositeFrame& frame, Tile tile, std::span<const TileCells> points,
                   const TileDots* dots, std::uint8_t* picture);

}  // namespace mote::render
