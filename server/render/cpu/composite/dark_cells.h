// SPDX-License-Identifier: GPL-3.0-or-later
//
// DarkCells tells where in the corrected bricks of a field of samples nothing shows, cell by cell, so that
// rays go past. It belongs to the bricks and a transfer function. Immutable once made; safe on any number of
// threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/render/plan/field_blocks.h"
#include "server/render/plan/grid_field.h"
#include "server/render/plan/transfer_table.h"

namespace mote::render {

/// What the table takes of a code: times the scale, plus the shift.
struct CodePlaces {
    float scale, shift;

    CodePlaces(const GridField& field, const TransferTable& table);
};

class DarkCells {
  public:
    /// Works in parallel. `blocks`: where the field is visible, one a brick.
    DarkCells(const GridField& field, const TransferTable& table, const VisibleBlocks& blocks);
    /// That those of a field take in memory.
    static std::uint64_t bytesOf(const GridField& field);

    /// Of each block: the place of its brick among the corrected, to be asked by rows; `unknown` where
    /// nothing is corrected and something may show; else, where nothing shows, `unknown` less the steps,
    /// diagonal ones included, to the next block where something may.
    const std::int32_t* places() const { return places_.data(); }
    static constexpr std::int32_t unknown = -1;

    static constexpr std::uint32_t rowsOfBrick = GridBricks::edge * GridBricks::edge;
    /// Of each corrected brick its rows of cells, y fastest; of a row its cells, 4 bits each from the lowest
    /// on: the steps, diagonal ones included, to the nearest cell of the brick in which something may show,
    /// 0 where it may in the cell itself; GridBricks::edge where it may in none.
    const std::uint32_t* rows() const { return rows_.data(); }

  private:
    std::vector<std::int32_t> places_;
    std::vector<std::uint32_t> rows_;
};

}  // namespace mote::render
