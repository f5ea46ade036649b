// SPDX-License-Identifier: GPL-3.0-or-later
//
// A TransferTable is a transfer function in cells of its values, as composites read it: running integrals of
// extinction, so that the mean over any segment of values is a difference (pre-integration in one dimension,
// for a ray along which the value changes linearly between two samples), their slopes, and colours; 16 bytes
// for one read. A value, safe on any number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/transfer_function.h"

namespace mote::render {

/// The colours of a transfer function alone, of values that show nothing as well: what of a volume of
/// particles is looked up by t.
TransferFunction colorsOf(TransferFunction transfer);

class TransferTable {
  public:
    static constexpr std::uint32_t cells = 4095;  ///< of t in [-LogDensity::fade, 1]; t = 0 ends one

    /// Values are counted as x: 1 at the table's low end, 1 + cells at its high one. At x = i: the integral
    /// of extinction over x up to i. Between i and i + 1: the extinction, per unit length of layer space,
    /// which changes linearly, from its start on by twice its bend; and the colour: red, green, blue from the
    /// lowest bits, each the square root of the linear component in 10 bits.
    struct alignas(16) Entry {
        float value;
        float start;
        std::uint32_t color;
        float bend;

        float mean() const { return start + bend; }  ///< extinction
    };
    struct Cell {
        double extinction = 0.0;  ///< mean, per unit length of layer space
        double change = 0.0;      ///< of extinction from the cell's beginning to its end
        /// Linear RGB, mean by extinction. Where there is none, that of the nearest cell which has some: what
        /// lies on a ray between the two has that one's colour.
        glm::dvec3 color{0.0};
    };

    /// Covers the function's span. Beyond its ends x goes on, and the first and the last entry hold.
    explicit TransferTable(const TransferFunction& transfer);
    /// The same of any two functions over [low, high].
    TransferTable(double low, double high, const std::function<double(double)>& extinction,
                  const std::function<glm::dvec3(double)>& color);

    double low() const { return low_; }
    double high() const { return high_; }
    const Entry* entries() const { return entries_.data(); }  ///< cells + 2
    /// The number of the first entry with extinction from each entry on; infinite where none has any.
    const float* nextVisible() const { return nextVisible_.data(); }
    /// Whether any value in [low, high] has extinction.
    bool visible(double low, double high) const;
    const std::vector<Cell>& ofCells() const { return ofCells_; }

  private:
    void spreadColors();
    void addEntries(double below, double above);
    void findNextVisible();

    double low_, high_;
    std::vector<Cell> ofCells_;
    std::vector<std::uint32_t> visibleBefore_;  ///< cells + 1: how many cells below the i-th have extinction
    std::vector<Entry> entries_;
    std::vector<float> nextVisible_;
};

}  // namespace mote::render
