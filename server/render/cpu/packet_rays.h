// SPDX-License-Identifier: GPL-3.0-or-later
//
// PacketRays: the rays of a packet of 4 x 4 pixels through one layer's volume. A value of one thread.
#pragma once

#include <array>
#include <cstdint>

#include "server/render/cpu/box_space.h"
#include "server/render/cpu/composite_frame.h"
#include "server/render/cpu/tile.h"

namespace mote::render {

/// A number for each pixel of a packet.
struct alignas(64) Lanes {
    std::array<float, Tile::packetPixels> values;

    float* data() { return values.data(); }
    const float* data() const { return values.data(); }
    float& operator[](std::size_t i) { return values[i]; }
};

/// A ray's way through the box is told by v from 0, where it enters, to 1, where it leaves:
/// v = clamp((slab - enter) * rate, 0, 1), and the place in cells is entry + v * travel. So no
/// rounding leads out of the padded volume. A ray that misses the box is past it everywhere.
struct PacketRays {
    std::array<Lanes, 3> entry;    ///< place in cells, of the BoxSpace
    std::array<Lanes, 3> travel;   ///< cells
    std::array<Lanes, 3> inverse;  ///< 1 / travel, finite
    Lanes length;                  ///< of the way, layer space
    bool meets = false;            ///< whether any ray meets the box

    // In the section that was entered.
    Lanes enter;            ///< slab; may lie outside the section
    Lanes rate;             ///< 1 / slabs
    Lanes start;            ///< v = clamp(slab * rate + start, 0, 1)
    bool hit = false;       ///< whether any ray meets the box there
    float nearest = 0.0F;   ///< slab in which the first ray enters
    float farthest = 0.0F;  ///< slab in which the last ray leaves
    float segment = 0.0F;   ///< slabs between two samples that bound a segment

    /// (x, y): the first pixel of the packet in the picture. No section is entered yet.
    void aim(const CompositeFrame& frame, const RayMap& rays, std::uint32_t x, std::uint32_t y,
             const BoxSpace& space);
    /// Where any ray meets the box.
    void enterSection(const FrameSection& section);

  private:
    std::array<double, Tile::packetPixels> enterMean_, leaveMean_;  // mean slabs, see FrameSection
    double crowded_ = 0.0;                                          // segments to a mean slab
};

}  // namespace mote::render
