// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkLine: a visible line of a scene on the screen: a piece of its silhouettes, borders or creases, before it
// is known whether a pen draws it. A value.
//
// Lines without needless points. Pure.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

namespace mote::render {

/// Where the surface turns away from the eye; where it ends; where it bends sharply; where it would turn away
/// if the eye moved a little.
enum class LineKind { silhouette, border, crease, suggestive };

struct LinePoint {
    glm::dvec2 at{0.0};  ///< pixels from the picture's upper left corner
    double depth = 0.0;  ///< along the line of sight, world units
    /// How much farther away lies what is beside the line than the line itself, from here to the next point:
    /// of the scene's extent in depth (Modalities::extent), at most 1; 1 beside nothing.
    double step = 0.0;
};

struct InkLine {
    LineKind kind = LineKind::silhouette;
    std::vector<LinePoint> points;  ///< at least two
    /// 0 to 1, the same from picture to picture: where lines are thinned out at once, those below a share
    /// stay. Of pictures in motion.
    float rank = 0.0F;
};

/// Leaves out points that lie within an eighth of a pixel of the way between others, where the depth steps
/// beside the line stay alike. `points`: at least two.
void simplify(std::vector<LinePoint>& points);

}  // namespace mote::render
