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
PointLook lit(const PointLook& rest, double toTau, const LessDrawn& less, double wanted) {
    PointLook look = rest;
    const double most = std::max(less.grows ? mostTau : mostTauUngrown, rest.light * toTau);
    look.size = std::max(rest.size * less.pixels, 1.0);
    if (less.grows && hiddenBy(most, look.size) < wanted)
        look.size = rootBetween(std::max(look.size, leastDisc), largest, wanted,
                                [&](double size) { return hiddenBy(most, size); });
    look.light = std::max(tauHiding(wanted, look.size, most) / toTau, std::numeric_limits<double>::min());
    return look;
}

PointLook opaque(const PointLook& rest, const LessDrawn& less, double wanted) {
    PointLook look = rest;
    const double most = less.grows ? std::max(mostOpaque, rest.opacity) : TransferFunction::opacityLimit;
    look.size = rest.size * less.pixels;
    if (less.grows && most * discArea(look.size) < wanted)
        look.size =
            rootBetween(look.size, largest, wanted, [&](double size) { return most * discArea(size); });
    look.opacity = std::min(wanted / discArea(look.size), most);
    return look;
}

}  // namespace

LessDrawn LessDrawn::of(double pixels, double share, double size, std::uint64_t points) {
    return {pixels, share, size > 1.0 || share * static_cast<double>(points) <= fewDiscs};
}

PointLook movingLook(const PointLook& rest, double toTau, const LessDrawn& less) {
    if (less.nothing()) return rest;
    const double square = less.pixels * less.pixels / less.share;
    if (rest.light > 0.0) return lit(rest, toTau, less, square * hiddenBy(rest.light * toTau, rest.size));
    return opaque(rest, less, square * rest.opacity * discArea(rest.size));
}

}  // namespace mote::render
