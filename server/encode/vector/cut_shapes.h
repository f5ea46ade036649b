// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is seen of a pen's strokes and dots on a page: lines and areas cut where what lies before them
// changes, each piece with its colour, without those that are hidden; and what they are cut and painted with.
// Pure functions.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <span>
#include <vector>

#include "server/encode/vector/shape_places.h"
#include "server/encode/vector/sight.h"
#include "server/render/plan/dot.h"
#include "server/render/plan/stroke.h"

namespace mote::server {

/// What is seen of a dot: all of it in one colour, or a piece where what lies before it differs from pixel to
/// pixel.
struct SeenDot {
    glm::vec3 color{0.0F};            ///< linear RGB, with what lies before it
    std::vector<glm::dvec2> outline;  ///< pixels from the dot's centre, closed; empty: the whole dot
};

/// In the rows of the picture. `plotter`: a pen has one colour and draws a dot or none: that of which half
/// comes through.
std::vector<SeenDot> seenOf(const render::Dot& dot, const Sight& sight, const PictureSize& size,
                            bool plotter);

/// What closed paths are cut to (Sutherland and Hodgman 1974).
struct ClipBox {
    glm::dvec2 low{0.0}, high{0.0};
};

/// What of a closed path lies in a box; if it would fall apart, its parts are joined along the box's
/// edges, which changes nothing of what it fills. Empty if nothing does.
std::vector<glm::dvec2> clipped(std::span<const glm::dvec2> path, const ClipBox& box);

/// A disc around the origin, of the same area.
std::vector<glm::dvec2> discPath(double radius);

/// The colour and the opacity with which a page shows something. Pages mix what is not opaque in encoded
/// colours, pictures in light: so paint is what gives the picture's colour where it lies on what is known to
/// be beneath it.
struct Paint {
    glm::vec3 color{0.0F};  ///< sRGB-encoded
    double opacity = 1.0;
};

/// sRGB-encoded, of linear RGB.
glm::vec3 encoded(const glm::vec3& linear);

/// `color`, `beneath`: linear RGB. No paler than `opacity` and `least`, and less so only where no colour
/// would do.
Paint paintOver(const glm::vec3& color, double opacity, const glm::vec3& beneath, double least = 0.0);

/// Pieces by their colour (linear RGB, with what lies before them): first, though it be empty, those before
/// which nothing lies, in the pen's; the others to a 64th of encoded colours. `plotter`: all in the pen's, of
/// that of which half comes through; an area of which as much does stays whole.
std::vector<render::Strokes> seenOf(const render::Strokes& strokes, const Sight& sight,
                                    const PictureSize& size, bool plotter);

}  // namespace mote::server
