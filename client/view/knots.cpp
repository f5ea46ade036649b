// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/knots.h"

#include <algorithm>

namespace mote::client {

Curve::Knot heldKnot(const std::vector<Curve::Knot>& knots, std::size_t index, Curve::Knot to,
                     const Interval& axis) {
    const double least = index > 0 ? knots[index - 1].x : axis.low;
    const double most = index + 1 < knots.size() ? knots[index + 1].x : axis.high;
    return {std::clamp(to.x, least, std::max(least, most)), std::clamp(to.y, 0.0, 1.0)};
}

std::size_t knotPlace(const std::vector<Curve::Knot>& knots, double x) {
    const auto above = std::upper_bound(knots.begin(), knots.end(), x,
                                        [](double at, const Curve::Knot& knot) { return at < knot.x; });
    return static_cast<std::size_t>(above - knots.begin());
}

}  // namespace mote::client
