// SPDX-License-Identifier: GPL-3.0-or-later
//
// PixelMap: a number for each pixel of a picture, and its exact mean over any square: a luminance, or how
// many dots are wanted where. Immutable, may be read from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace mote::render {

class PixelMap {
  public:
    /// `values`: width x height, at least one, rows from the top; finite and not negative.
    PixelMap(std::uint32_t width, std::uint32_t height, std::vector<float> values);

    std::uint32_t width() const { return width_; }    ///< pixels
    std::uint32_t height() const { return height_; }  ///< pixels
    std::span<const float> row(std::size_t y) const { return {&values_[y * width_], width_}; }
    float at(std::size_t x, std::size_t y) const { return values_[y * width_ + x]; }
    /// That it takes in memory.
    std::uint64_t bytes() const {
        return values_.capacity() * sizeof(values_[0]) + sums_.capacity() * sizeof(sums_[0]);
    }
    /// The sum of all pixels.
    double total() const { return sums_.back(); }

    /// The mean over the square of side `side` (pixels, at least 1 is taken) around (x, y), as far as it lies
    /// in the picture; a centre outside counts as the nearest inside. By a summed-area table (Crow 1984).
    double mean(double x, double y, double side) const;

  private:
    double sum(double x, double y) const;

    std::uint32_t width_;
    std::uint32_t height_;
    std::vector<float> values_;
    std::vector<double> sums_;  ///< (width + 1) x (height + 1): of all pixels above and to the left
};

}  // namespace mote::render
