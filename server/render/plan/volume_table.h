// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeTable: a volume's transfer functions as the composite reads them: running integrals of extinction
// over t with their slopes, and colours, 16 bytes for one read. Built from a style; a value, safe on
// any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/plan/transfer_table.h"

namespace mote::render {

class VolumeTable {
  public:
    static constexpr std::uint32_t cells = TransferTable::cells;

    /// t is counted as x: 1 at the table's low end, 1 + cells at its high one. At x = i: the integral of
    /// extinction over x up to i. Between i and i + 1: the extinction, per unit length of layer space, which
    /// changes linearly, from its start on by twice its bend; and the colour: red, green, blue from the
    /// lowest bits, each the square root of the linear component in 10 bits.
    struct alignas(16) Entry {
        float value;
        float start;
        std::uint32_t color;
        float bend;

        float mean() const { return start + bend; }  ///< extinction
    };

    explicit VolumeTable(const ParticlesStyle& style);
    /// As TransferTable. Beyond its ends x goes on, and the first and the last entry hold.
    VolumeTable(double low, double high, const std::function<double(double)>& extinction,
                const std::function<glm::dvec3(double)>& color);

    double low() const { return table_.low(); }
    double high() const { return table_.high(); }
    const Entry* entries() const { return entries_.data(); }  ///< cells + 2
    /// Of each entry, the number of the first one from it on that has extinction; infinite where none has.
    const float* nextVisible() const { return nextVisible_.data(); }
    bool visible(double low, double high) const { return table_.visible(low, high); }

  private:
    TransferTable table_;
    std::vector<Entry> entries_;
    std::vector<float> nextVisible_;
};

}  // namespace mote::render
