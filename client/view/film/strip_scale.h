// SPDX-License-Identifier: GPL-3.0-or-later
//
// StripScale: where a time lies on the strip of keyframes. A value; pure functions.
#pragma once

#include <algorithm>
#include <cmath>

namespace mote::client {

struct StripScale {
    double begin = 0.0, end = 1.0;    ///< seconds; begin < end
    float left = 0.0F, width = 1.0F;  ///< pixels

    /// Shows a film and a piece after it, which keyframes are dragged into. `margin` pixels stay free on both
    /// sides.
    static StripScale of(double begin, double end, float left, float width, float margin) {
        const double first = std::min(begin, 0.0);
        const double last = std::max(first + 5.0, end + 0.15 * (end - first));
        return {first, last, left + margin, std::max(width - 2.0F * margin, 1.0F)};
    }

    float at(double seconds) const {
        return left + static_cast<float>((seconds - begin) / (end - begin) * static_cast<double>(width));
    }
    /// Times off the strip are its ends'.
    double from(float x) const {
        const double share = std::clamp(static_cast<double>((x - left) / width), 0.0, 1.0);
        return begin + share * (end - begin);
    }

    /// Seconds between marks: 1, 2 or 5 times a power of ten, at least so many pixels apart.
    double markSpacing(float pixels) const {
        const double least = (end - begin) * static_cast<double>(pixels / width);
        const double power = std::pow(10.0, std::floor(std::log10(least)));
        for (const double factor : {1.0, 2.0, 5.0})
            if (factor * power >= least) return factor * power;
        return 10.0 * power;
    }
};

}  // namespace mote::client
