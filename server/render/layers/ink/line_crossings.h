// SPDX-License-Identifier: GPL-3.0-or-later
//
// LineCrossings: where lines pass in front of one another on the screen. What is seen of a line changes
// there, or where surfaces go through each other (Appel 1967, The notion of quantitative invisibility). Made
// for a view, immutable; any number of threads may ask.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <stop_token>
#include <vector>

namespace mote::render {

/// A straight line on the screen. `nearness` is linear along it and greater for what is nearer.
struct ScreenLine {
    glm::dvec2 from{0.0}, to{0.0};  ///< pixels from the picture's upper left corner
    double nearnessFrom = 0.0, nearnessTo = 0.0;
};

class LineCrossings {
  public:
    /// `margin`: pixels beside the picture up to which lines are of interest.
    LineCrossings(std::vector<ScreenLine> lines, std::uint32_t width, std::uint32_t height, double margin,
                  const std::stop_token& stop);

    /// Fills `shares` with the places of a line, 0 to 1 on the screen, in order, where a nearer one crosses
    /// it.
    void along(const ScreenLine& line, std::vector<double>& shares) const;

  private:
    /// In squares of the grid.
    ScreenLine onGrid(const ScreenLine& line) const;

    std::vector<ScreenLine> lines_;
    double margin_;
    std::uint32_t columns_, rows_;
    std::vector<std::uint32_t> begins_;  // of each square's lines; one more than squares
    std::vector<std::uint32_t> inside_;  // numbers of lines
};

}  // namespace mote::render
