// SPDX-License-Identifier: GPL-3.0-or-later
//
// A Quality says how far a device may stray from the reference picture; beside it stands what else a plan is
// told. Values.
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

/// Whether a plan takes the time to read what is not in memory. `notForPoints`: where the device can, it
/// shows of the points what the preview offers instead.
enum class Reading { all, notForPoints };

/// What a device knows to draw.
struct DeviceAbilities {
    bool preview = false;   ///< PointsPlan::preview
    bool allPoints = true;  ///< from this process's memory: PointsPlan::need asks for them
};

}  // namespace mote::render
