// SPDX-License-Identifier: GPL-3.0-or-later
//
// A Fragment is what a surface is in one pixel (docs/PICTURE.md, "Meshes"): a dot that covers this pixel and
// no other. The processor makes it; a device only draws it. A value; a list of them is immutable and shared
// by plans.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace mote::render {

struct Fragment {
    std::uint32_t column = 0, row = 0;  ///< of its pixel, row 0 on top
    double depth = 0.0;                 ///< along the line of sight, world units; finite
    float opacity = 1.0F;               ///< above 0, at most 1
    glm::vec3 color{1.0F};              ///< linear RGB
};

/// In any order; of equal depth in a pixel the earlier one lies in front.
using Fragments = std::vector<Fragment>;

}  // namespace mote::render
