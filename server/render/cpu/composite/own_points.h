// SPDX-License-Identifier: GPL-3.0-or-later
//
// OwnPoints: the points of a vector of pixels, pixel by pixel from front to back, and the light that is told
// where they begin and end. Row k of so many rays holds what each of them has as its k-th. Reused from packet
// to packet by the thread that owns it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace mote::render {

struct OwnPoints {
    std::vector<float> tau;                  ///< optical depths; 0: a pixel has no more
    std::vector<float> borders;              ///< slabs in which points begin and end, two rows each
    std::vector<float> mostLeft;             ///< by the field before a border, if nothing more is seen
    std::vector<std::array<float, 4>> told;  ///< likewise

    /// Room for so many rows; from `first` on their optical depths are 0.
    void makeRoom(std::size_t first, std::size_t rows, std::size_t rays) {
        if (tau.size() < rows * rays) {
            tau.resize(rows * rays);
            borders.resize(rows * rays);
            mostLeft.resize(rows * rays);
            told.resize(rows * rays);
        }
        std::fill(tau.begin() + static_cast<std::ptrdiff_t>(first * rays),
                  tau.begin() + static_cast<std::ptrdiff_t>(rows * rays), 0.0F);
    }
};

}  // namespace mote::render
