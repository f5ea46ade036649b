// SPDX-License-Identifier: GPL-3.0-or-later
//
// StrokeBands: which strokes may touch which rows of a picture, told by bands of a few rows. Made for one
// picture's fragments; immutable, safe on any number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "server/render/plan/stroke.h"

namespace mote::render {

/// Pixels of a side from `begin` to before `end`.
struct PixelSpan {
    std::uint32_t begin = 0, end = 0;

    bool empty() const { return begin >= end; }
};

/// The pixels, of `side` in all, whose middles lie between two places. Inline and without ceil and floor: it
/// is asked for every row of every segment.
inline PixelSpan pixelsBetween(double low, double high, std::uint32_t side) {
    const double first = std::min<double>(side, std::max(0.0, low - 0.5));
    const auto begin = static_cast<std::uint32_t>(first);
    const auto end = static_cast<std::uint32_t>(std::min<double>(side, std::max(0.0, high + 0.5)));
    return {begin < first ? begin + 1 : begin, end};
}

class StrokeBands {
  public:
    static constexpr std::uint32_t rows = 8;  ///< of a band

    StrokeBands(const Strokes& strokes, std::uint32_t width, std::uint32_t height);

    std::uint32_t count() const { return static_cast<std::uint32_t>(begin_.size()) - 1; }
    /// What may touch a band, in order: lines by their number, areas by theirs behind that of all lines.
    std::span<const std::uint32_t> of(std::uint32_t band) const {
        return std::span(items_).subspan(begin_[band], begin_[band + 1] - begin_[band]);
    }
    /// Pixels from a line's nearest place from which on it covers nothing.
    double reach(std::uint32_t line) const { return reach_[line]; }

  private:
    std::vector<double> reach_;  // of lines
    std::vector<std::size_t> begin_;
    std::vector<std::uint32_t> items_;
};

}  // namespace mote::render
