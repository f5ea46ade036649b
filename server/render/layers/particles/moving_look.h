// SPDX-License-Identifier: GPL-3.0-or-later
//
// movingLook: how points look in a picture of fewer points and pixels, so that its light is that of the exact
// one (docs/PICTURE.md, "What a device may do"). Pure functions.
#pragma once

#include <cstdint>

#include "server/render/plan/points_plan.h"

namespace mote::render {

/// What a picture has less than the exact one.
struct LessDrawn {
    double pixels = 1.0;  ///< of it, a pixel of the exact one: across or down
    double share = 1.0;   ///< of the points that is drawn
    bool grows = true;    ///< points may be larger for it; discs take long to draw

    /// So many discs take no longer than ten times as many points of a pixel: points of one grow up to here.
    static constexpr double fewDiscs = 1 << 17;
    /// What does not grow keeps its light down to such a share of the points, but for what a lone one hides.
    static double leastShare(double pixels) { return 0.2 * pixels * pixels; }

    /// Of so many points, whose diameter at rest is `size`.
    static LessDrawn of(double pixels, double share, double size, std::uint64_t points);
    bool nothing() const { return pixels == 1.0 && share == 1.0; }
};

/// `rest`: in the exact picture, all in its pixels; `toTau`: times its light, the optical depth of a point
/// where the camera looks. Of points of which a share is left out at random, one that hid the part a of a
/// pixel must hide a / share, whatever their number: then what all leave is the same on average. If that
/// is more than a point may (hidden_area.h; of points whose opacity is said 0.95), they are larger besides;
/// if they do not grow, light is lost.
PointLook movingLook(const PointLook& rest, double toTau, const LessDrawn& less);

}  // namespace mote::render
