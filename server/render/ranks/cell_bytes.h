// SPDX-License-Identifier: GPL-3.0-or-later
//
// The cells of a tile that hold points, as ranks send them to the tile's owner, and their sum there. Pure
// functions.
#pragma once

#include <span>

#include "server/render/cpu/tile_cells.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {

/// The most bytes that a tile with so many layers takes.
std::size_t mostCellBytes(std::uint32_t slabs, std::size_t layers);

/// The cells of all layers.
Bytes packCells(std::span<const TileCells> layers);

/// Adds what packCells made of as many layers with as many slabs.
void addCells(std::span<const std::byte> packed, std::span<TileCells> layers);

}  // namespace mote::render
