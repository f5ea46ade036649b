// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace mote {

double TransferFunction::extinction(double value) const {
    const bool fades = fade > 0.0;
    const double within = fades ? std::max(value, 0.0) : value;
    const double full = -std::log1p(-std::min(opacity(within), opacityLimit)) / opacityLength;
    return fades ? full * std::clamp(1.0 + value / fade, 0.0, 1.0) : full;
}

glm::dvec3 TransferFunction::color(double value) const {
    if (colors.empty()) return colorMap((value - colorRange.low) / (colorRange.high - colorRange.low));
    const auto& knots = opacity.knots();
    const auto above = std::upper_bound(knots.begin(), knots.end(), value,
                                        [](double v, const Curve::Knot& knot) { return v < knot.x; });
    if (above == knots.begin()) return colors.front();
    if (above == knots.end()) return colors.back();
    const auto i = static_cast<std::size_t>(above - knots.begin());
    return glm::mix(colors[i - 1], colors[i], (value - knots[i - 1].x) / (knots[i].x - knots[i - 1].x));
}

}  // namespace mote
