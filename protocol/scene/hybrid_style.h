// SPDX-License-Identifier: GPL-3.0-or-later
//
// The look of a hybrid volume: which of its representations is drawn, its transfer function, the shape of its
// points, its light and what is cut away: its message, resolved (fields/resolve.h), and HybridStyle, which is
// made of it for who draws. Source: section 3.2.2 of the dissertation. Values and pure functions.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/clip.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/curve.h"
#include "protocol/scene/light.h"
#include "protocol/scene/transfer_function.h"

namespace mote {

enum class HybridRepresentation {
    best,  ///< of what the dataset has: its residual, else its points
    points,
    residual,
    volume,  ///< the low-resolution volume alone
};

/// How a point fills its cell of the error grid, towards its neighbours.
enum class PointShape {
    square,    ///< evenly, with sharp faces
    disc,      ///< evenly in the middle
    gaussian,  ///< evenly nowhere: as the source is interpolated
};

/// What of a volume is drawn.
enum class HybridShows {
    matter,
    maximum,  ///< the greatest value on each ray
    surface,  ///< that of one value
};

/// As drawn.
struct HybridStyle {
    /// The length over which a constant value has the curve's opacity, over the volume's longest edge.
    static constexpr double opacityShare = 1.0 / 256.0;
    static constexpr int mostClipPlanes = mote::mostClipPlanes;

    HybridRepresentation representation;
    std::optional<Curve> opacity;  ///< value -> opacity over opacityShare; none: as the dataset's values ask
    std::vector<glm::dvec3> colors;  ///< linear RGB, one a knot of the curve; empty: of the colour map
    ColorMap colorMap;
    std::optional<ValueRange>
        colorRange;  ///< of the colour map; none: from the curve's first knot to its last
    bool ownColors;  ///< somebody chose them; else a curve that follows the values brings its own
    PointShape pointShape;
    double pointOpacity;  ///< 0 to 1: how much of a point's correction is applied
    Light light;
    std::vector<HalfSpace> clipPlanes;  ///< in layer space; what lies in all of them is drawn
    std::optional<Bounds> clipBox;      ///< in layer space
    HybridShows shows;
    std::optional<double> isovalue;  ///< of the surface; none: where the opacity begins
    double silhouettes;              ///< 0 to 1: how much darker is what turns away from the eye
    double gradientOpacity;          ///< 0 to 1: how much of its extinction goes with its slope

    /// The weight of the second of two samples is clamp((share - 1/2) * steepness + 1/2, 0, 1), by the share
    /// of the way to it.
    double pointSteepness() const {
        return pointShape == PointShape::square ? 8.0 : pointShape == PointShape::disc ? 2.0 : 1.0;
    }
};

/// Fills every default, and makes unit vectors of the planes' normals. Errors: a number out of range, a curve
/// that descends, some knots with a colour and some without, an unknown representation, shape or colour map,
/// an empty range or box, a normal of length 0, a light that casts shadows.
Result<proto::HybridStyle> parseHybridStyle(proto::HybridStyle message);

/// Of a parsed message.
HybridStyle hybridStyleOf(const proto::HybridStyle& message);

}  // namespace mote
