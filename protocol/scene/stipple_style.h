// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleStyle: the look of a stipple layer: how dense its dots are on the screen, and what they are like.
// Source: sections 2.2.3 and 2.2.5 of the dissertation. A value; a parsed one is valid.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/error.h"
#include "protocol/scene/length_scale.h"
#include "protocol/scene/light.h"

namespace mote {

/// What drives colour and size of a dot; each goes from 0 to 1.
enum class DotValue {
    none,
    tone,   ///< share of the full density
    depth,  ///< from the nearest point of the surface to the farthest
    x,
    y,
    z,  ///< place along an axis of the surface's bounds
};

struct StippleStyle {
    // In pixels of the full-resolution picture.
    ScreenLength spacing = ScreenLength::usual(5.0);       ///< between dots where the tone is full
    ScreenLength dotSize = ScreenLength::usual(2.0);       ///< diameter
    ScreenLength leastDotSize = ScreenLength::usual(2.0);  ///< where the value is 0
    double opacity = 1.0;                                  ///< of a dot
    glm::dvec3 color{1.0};                                 ///< linear RGB
    DotValue value = DotValue::none;
    std::optional<ColorMap> colorMap;  ///< value -> linear RGB, instead of the colour
    Light light;
    double gamma = 1.0;  ///< brightness ^ gamma gives the tone
    bool denseDark =
        false;            ///< dots are dense where it is dark: ink that is darker than its paper, or inverted
    double jitter = 0.5;  ///< strength of the edge jitter, 0: none
    bool soft = false;    ///< dots fade and glide
    bool seeThrough = false;    ///< a surface hides no dots of its own
    std::string image;          ///< "ROOT/NAME", or empty
    bool sourceLayers = false;  ///< the layers before it are the image

    /// It stipples a picture, on the picture's plane.
    bool onPlane() const { return !image.empty() || sourceLayers; }
    bool operator==(const StippleStyle&) const = default;
};

/// Fills every default; `background` (linear RGB) is the paper. Errors: a number out of range, an unknown
/// value, colour map or source, an image together with a source.
Result<StippleStyle> parseStippleStyle(const proto::StippleStyle& message, const glm::dvec3& background);

}  // namespace mote
