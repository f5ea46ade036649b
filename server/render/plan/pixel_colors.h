// SPDX-License-Identifier: GPL-3.0-or-later
//
// PixelColors: the colour that the points of a layer have in each pixel where they are coloured by a column
// (docs/PICTURE.md, "Colour by a column"). It depends on all of a pixel's points and on nothing else, so it
// is found before anything is composited, by the processor for all devices. An immutable value.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <utility>
#include <vector>

namespace mote::render {

class PixelColors {
  public:
    /// `places` in `colors`, row by row, all of which there are; `counts` and `pointsCounted` as below.
    PixelColors(std::uint32_t width, std::uint32_t height, std::vector<glm::vec3> colors,
                std::vector<std::uint16_t> places, std::vector<std::uint32_t> counts = {},
                std::uint64_t pointsCounted = 0)
        : width_(width),
          height_(height),
          colors_(std::move(colors)),
          places_(std::move(places)),
          counts_(std::move(counts)),
          pointsCounted_(pointsCounted) {}

    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }
    /// In a pixel of the picture. Linear RGB.
    const glm::vec3& at(std::uint32_t column, std::uint32_t row) const {
        return colors_[places_[std::size_t{row} * width_ + column]];
    }

    /// How many points each pixel holds, where the search for values counted all of them: each is of at most
    /// a pixel and has a value, or the nearest was looked for; then a pixel that hides all behind it may have
    /// less. Else empty; on other processes, too.
    const std::vector<std::uint32_t>& counts() const { return counts_; }
    /// How many points these stand for; 0: their sum.
    std::uint64_t pointsCounted() const { return pointsCounted_; }
    const std::vector<glm::vec3>& colors() const { return colors_; }
    const std::vector<std::uint16_t>& places() const { return places_; }

  private:
    std::uint32_t width_, height_;
    std::vector<glm::vec3> colors_;
    std::vector<std::uint16_t> places_;  // in colors_, by pixel
    std::vector<std::uint32_t> counts_;
    std::uint64_t pointsCounted_;
};

/// One of the plan's points each; null where they have one colour.
using FrameColors = std::vector<std::shared_ptr<const PixelColors>>;

}  // namespace mote::render
