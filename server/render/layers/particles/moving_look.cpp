// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/moving_look.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/render/plan/hidden_area.h"

namespace mote::render {
namespace {

constexpr double mostOpaque = 0.95;                       // of a point whose opacity is said
constexpr double leastDisc = 1.0 + 1e-6, largest = 64.0;  // pixels; a disc hides more than what is no larger

/// `wanted`: square pixels that a point is to hide.
PointLook lit(const PointLook& rest, double toTau, double pixels, double wanted) {
    PointLook look = rest;
    const double most = std::max(-std::log1p(-mostHidden), rest.light * toTau);
    look.size = std::max(rest.size * pixels, 1.0);
    if (hiddenBy(most, look.size) < wanted)
        look.size = rootBetween(std::max(look.size, leastDisc), largest, wanted,
                                [&](double size) { return hiddenBy(most, size); });
    look.light = std::max(tauHiding(wanted, look.size, most) / toTau, std::numeric_limits<double>::min());
    return look;
}

PointLook opaque(const PointLook& rest, double pixels, double wanted) {
    PointLook look = rest;
    const double most = std::max(mostOpaque, rest.opacity);
    look.size = rest.size * pixels;
    if (most * discArea(look.size) < wanted)
        look.size =
            rootBetween(look.size, largest, wanted, [&](double size) { return most * discArea(size); });
    look.opacity = std::min(wanted / discArea(look.size), most);
    return look;
}

}  // namespace

PointLook movingLook(const PointLook& rest, double toTau, const LessDrawn& less) {
    if (less.nothing()) return rest;
    const double square = less.pixels * less.pixels / less.share;
    if (rest.light > 0.0)
        return lit(rest, toTau, less.pixels, square * hiddenBy(rest.light * toTau, rest.size));
    return opaque(rest, less.pixels, square * rest.opacity * discArea(rest.size));
}

}  // namespace mote::render
