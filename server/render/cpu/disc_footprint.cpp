// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/disc_footprint.h"

namespace mote::render {

DiscFootprint::DiscFootprint(double size, double opacity) : reach_(static_cast<float>(0.5 * size + 0.5)) {
    // A pixel of coverage c has the opacity c * opacity: its optical depth is not in proportion.
    for (std::uint32_t i = 0; i <= steps; ++i) {
        const double coverage = static_cast<double>(i) / steps;
        const double share =
            opacity > 0.0 ? std::log1p(-opacity * coverage) / std::log1p(-opacity) : coverage;
        weight_[i] = static_cast<float>(share);
    }
}

}  // namespace mote::render
