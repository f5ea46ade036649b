// SPDX-License-Identifier: GPL-3.0-or-later
//
// Easing: how the way from one keyframe to the next, or of a move, goes in time. Pure functions.
#pragma once

#include <optional>
#include <string_view>

namespace mote {

enum class Easing {
    linear,
    smooth,  ///< slow at both ends
    hold,    ///< what was stays, then jumps
};

/// "" is linear; nothing where the word is not known.
inline std::optional<Easing> parseEasing(std::string_view word) {
    if (word.empty() || word == "linear") return Easing::linear;
    if (word == "smooth") return Easing::smooth;
    if (word == "hold") return Easing::hold;
    return std::nullopt;
}

/// From 0 to 1 with the given slopes at 0 and 1, each 0 or 1: it never goes back.
inline double easedBetween(double share, double slopeAtBegin, double slopeAtEnd) {
    const double rest = 1.0 - share;
    return share * (rest * (rest * slopeAtBegin - share * slopeAtEnd) + share * (3.0 - 2.0 * share));
}

/// The share of the way at a share of its time.
inline double eased(Easing easing, double share) {
    if (easing == Easing::hold) return share < 1.0 ? 0.0 : 1.0;
    return easing == Easing::smooth ? easedBetween(share, 0.0, 0.0) : share;
}

}  // namespace mote
