// SPDX-License-Identifier: GPL-3.0-or-later
//
// A Dot is what stipple layers give a picture: a disc of constant size on the screen (docs/PICTURE.md,
// "Dots"). The processor makes it; a device only draws it. A value; a list of them is immutable and shared by
// plans.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

namespace mote::render {

struct Dot {
    float x = 0.0F;  ///< of its centre, pixels from the picture's upper left corner
    float y = 0.0F;
    /// Depth along the line of sight, world units; infinity: behind all that has a depth, -infinity: in front
    /// of it.
    double depth = 0.0;
    float radius = 1.0F;    ///< pixels
    float opacity = 1.0F;   ///< 0 to 1
    glm::vec3 color{1.0F};  ///< linear RGB

    bool operator==(const Dot&) const = default;
};

/// The earlier of two dots of equal depth lies in front.
using Dots = std::vector<Dot>;

/// How a dot covers pixels, by the distance of a pixel's centre from its own: clamp(reach - distance, 0, 1)
/// * most. All that it covers adds up to the disc's area, pi radius^2.
struct DotFootprint {
    float reach;  ///< pixels; nothing is covered from here on
    float most;   ///< at its centre

    DotFootprint(float reaches, float covers) : reach(reaches), most(covers) {}
    explicit DotFootprint(float radius)
        : reach(std::sqrt(std::max(radius * radius, 1.0F / 3.0F) - 1.0F / 12.0F) + 0.5F),
          most(std::min(3.0F * radius * radius, 1.0F)) {}
    float coverage(float distance) const { return most * std::clamp(reach - distance, 0.0F, 1.0F); }
};

}  // namespace mote::render
