// SPDX-License-Identifier: GPL-3.0-or-later
//
// Quality: how far a device may stray from the reference picture. A value.
#pragma once

#include <cstdint>

namespace mote::render {

struct Quality {
    double resolutionScale = 1.0;  ///< of the view's width and height, in (0, 1]
    double pointFraction = 1.0;   ///< of the points that the exact picture draws; what is left out is made up
                                  ///< for by the opacity of the others
    std::uint32_t slabs = 192;    ///< depth slabs in which points and volume mix evenly
    double samplesPerCell = 4.0;  ///< volume samples along a ray, a cell's edge

    static Quality exact() { return {}; }
    bool operator==(const Quality&) const = default;
};

}  // namespace mote::render
