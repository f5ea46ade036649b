// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/curve.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/base/check.h"

namespace mote {

Result<Curve> Curve::create(std::vector<Knot> knots, double least, double greatest) {
    constexpr std::size_t most = 256;
    if (knots.empty() || knots.size() > most) {
        return Error{ErrorCode::invalidArgument, "",
                     fmt::format("a curve has 1 to {} knots, not {}", most, knots.size())};
    }
    for (std::size_t i = 0; i < knots.size(); ++i) {
        const auto at = fmt::format("[{}]", i);
        MOTE_RETURN_IF_ERROR(checkRange(knots[i].x, least, greatest, at));
        MOTE_RETURN_IF_ERROR(checkRange(knots[i].y, 0.0, 1.0, at));
        if (i > 0 && knots[i].x < knots[i - 1].x) {
            return Error{ErrorCode::invalidArgument, at, "knots must ascend"};
        }
    }
    return Curve(std::move(knots));
}

Curve Curve::constant(double y) {
    return Curve({{0.0, y}});
}

double Curve::operator()(double x) const {
    const auto above =
        std::upper_bound(knots_.begin(), knots_.end(), x, [](double v, const Knot& k) { return v < k.x; });
    if (above == knots_.begin()) return knots_.front().y;
    if (above == knots_.end()) return knots_.back().y;
    const Knot& a = *(above - 1);
    return a.y + (above->y - a.y) * (x - a.x) / (above->x - a.x);
}

double Curve::maximum() const {
    return std::max_element(knots_.begin(), knots_.end(), [](auto& a, auto& b) { return a.y < b.y; })->y;
}

}  // namespace mote
