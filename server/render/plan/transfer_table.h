// SPDX-License-Identifier: GPL-3.0-or-later
//
// TransferTable: a volume's transfer functions in cells of t, whose running integrals give the mean over any
// stretch of t as a difference (pre-integration in one dimension, for a ray along which t changes linearly
// between two samples). A value.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/particles_style.h"

namespace mote::render {

class TransferTable {
  public:
    static constexpr std::uint32_t cells = 4095;  ///< of t in [-LogDensity::fade, 1]; t = 0 ends one

    explicit TransferTable(const ParticlesStyle& style);
    /// Of any functions over [low, high]; beyond, both are as at its ends. What is said of t below holds of
    /// this range.
    TransferTable(double low, double high, const std::function<double(double)>& extinction,
                  const std::function<glm::dvec3(double)>& color);

    double low() const { return low_; }
    double high() const { return high_; }
    struct Cell {
        double extinction = 0.0;  ///< mean, per unit length of layer space
        double change = 0.0;      ///< of extinction from the cell's beginning to its end
        /// Linear RGB, mean by extinction. Where there is none, that of the nearest cell which has some: what
        /// lies on a ray between the two has that one's colour.
        glm::dvec3 color{0.0};
    };
    const std::vector<Cell>& ofCells() const { return ofCells_; }
    /// Whether any t in [low, high] has extinction.
    bool visible(double low, double high) const;

  private:
    void spreadColors();

    double low_, high_;
    std::vector<Cell> ofCells_;
    std::vector<std::uint32_t> visibleBefore_;  ///< cells + 1: how many cells below the i-th have extinction
};

}  // namespace mote::render
