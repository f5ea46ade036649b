// SPDX-License-Identifier: GPL-3.0-or-later
//
// LogDensity: the map from a density to its scaled log density t, shared by all steps of a plot. A value.
//
// t is 0 at the plot's least leaf density and 1 at its greatest. A leaf's t lies in [0, 1]. A cell of the
// volume may be thinner than any leaf, or empty: its t goes down to -fade, where extinction has faded to
// nothing. This keeps the interpolated field continuous at the border of the beam and empty space transparent
// whatever the curve says.
#pragma once

#include <algorithm>
#include <cmath>

namespace mote {

struct LogDensity {
    static constexpr double fade = 0.125;

    double min = 1.0;  ///< the plot's least leaf density, weight per plot volume, > 0
    double max = 1.0;  ///< the plot's greatest

    /// A leaf's t, in [0, 1]; 0 where the plot knows only one density.
    double ofLeaf(double density) const {
        if (!(max > min)) return 0.0;
        return std::clamp(std::log(density / min) / std::log(max / min), 0.0, 1.0);
    }

    /// A volume cell's t, in [-fade, 1]; -fade where it is empty.
    double ofCell(double density) const {
        if (!(density > 0.0)) return -fade;
        if (!(max > min)) return density >= min ? 0.0 : -fade * (1.0 - density / min);
        return std::clamp(std::log(density / min) / std::log(max / min), -fade, 1.0);
    }
};

}  // namespace mote
