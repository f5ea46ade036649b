// SPDX-License-Identifier: GPL-3.0-or-later
//
// PaletteMaker: the palette of a film, from all its frames. It counts colours in 64 x 64 x 64 cells, halves
// the set where its spread is greatest until there are enough parts, and moves each colour into the middle
// of those that are nearest to it. A film of few colours keeps them as they are. One owner, one thread at a
// time; 8 MiB.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/frames/video/gif_palette.h"

namespace mote::client {

class PaletteMaker {
  public:
    PaletteMaker();

    /// RGBA pixels of a frame, sRGB-encoded; alpha is ignored.
    void add(std::span<const std::uint8_t> rgba);
    /// The same frames give the same palette. Black alone where nothing was added.
    GifPalette make() const;

  private:
    struct Cell {
        std::uint64_t count = 0, r = 0, g = 0, b = 0;  ///< sums
    };

    std::vector<Cell> cells_;
    std::vector<std::uint32_t> exact_;  ///< the distinct colours, ascending, while they are few
    bool few_ = true;
};

}  // namespace mote::client
