// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleStyle: the look of a stipple layer: how dense its dots are on the screen, and what they are like:
// its message, resolved (fields/resolve.h), with a colour and the tones in which dots are dense. Source:
// sections 2.2.3 and 2.2.5 of the dissertation.
#pragma once

#include <glm/vec3.hpp>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote {

using StippleStyle = proto::StippleStyle;

/// Dots of a picture so far apart, in diameters, leave no paper where the tone is full: it is their spacing
/// where nobody says one.
inline constexpr double solidSpacing = 0.71;
/// Their diameter where nobody says it, pixels of a picture of so many lines, and of any smaller one: the
/// edges of smaller dots leave paper between them.
inline constexpr double pictureDot = 2.5, pictureLines = 960.0;

/// It stipples a picture, on the picture's plane.
inline bool onPlane(const StippleStyle& style) {
    return !style.image().empty() || !style.source().empty();
}

/// Dots are dense where it is dark: ink that is darker than its paper, or inverted.
inline bool denseInDark(const StippleStyle& style) {
    return style.dense() == "dark";
}

/// Fills every default; `background` (linear RGB) is the paper. Errors: a number out of range, an unknown
/// word or colour map, an image together with a source.
Result<StippleStyle> parseStippleStyle(StippleStyle message, const glm::dvec3& background);

}  // namespace mote
