// SPDX-License-Identifier: GPL-3.0-or-later
//
// How much of a picture a point hides (docs/PICTURE.md, "Points"), in square pixels. Pure functions.
#pragma once

namespace mote::render {

/// The area of a disc of such a diameter, as it covers pixels.
double discArea(double size);

/// What a lit point hides where it covers all, it has this optical depth: 1 - exp(-tau * coverage), summed up
/// over a disc whose edge is a pixel wide; of a size of up to 1, over one pixel.
double hiddenBy(double tau, double size);

/// The optical depth, at most `most`, at which a lit point hides so much.
double tauHiding(double area, double size, double most);

/// The root of what grows, between two places.
template <class Grows>
double rootBetween(double low, double high, double wanted, const Grows& grows) {
    constexpr int halvings = 60;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (low + high);
        (grows(middle) < wanted ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// The most optical depth of a point that stands for others, where the camera looks: it hides 0.7 of a pixel,
/// or points nearer than that would have to hide more than all. Of those that do not grow for it, 0.95.
inline constexpr double mostTau = 1.204, mostTauUngrown = 2.996;

}  // namespace mote::render
