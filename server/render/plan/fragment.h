// SPDX-License-Identifier: GPL-3.0-or-later
//
// A Fragment is what a surface is in one pixel (docs/PICTURE.md, "Meshes"): a dot that covers this pixel and
// no other. The processor makes it; a device only draws it. A value; a list of them is immutable and shared
// by plans. Those of a large picture may be more than memory holds: surfaces and strokes make theirs where
// they are drawn.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace mote::render {

struct Fragment {
    std::uint32_t column = 0, row = 0;  ///< of its pixel, row 0 on top
    double depth = 0.0;     ///< along the line of sight, world units; infinity: behind all that has one
    float opacity = 1.0F;   ///< above 0, at most 1
    glm::vec3 color{1.0F};  ///< linear RGB
};

/// In any order; of equal depth in a pixel the earlier one lies in front.
using Fragments = std::vector<Fragment>;

/// Pixels of a picture: columns [left, right), rows [top, bottom).
struct PixelRect {
    std::uint32_t left = 0, top = 0, right = 0, bottom = 0;

    bool empty() const { return left >= right || top >= bottom; }
};

/// FragmentMaker: makes fragments where they are drawn. Immutable; any number of threads.
class FragmentMaker {
  public:
    virtual ~FragmentMaker() = default;
    /// Appends those of some pixels: the same as those of all, in the same order in each pixel. Throws
    /// std::bad_alloc, also where there would be more of a tile's than fit.
    virtual void make(const PixelRect& pixels, Fragments& fragments) const = 0;

  protected:
    FragmentMaker() = default;
    FragmentMaker(const FragmentMaker&) = default;
    FragmentMaker& operator=(const FragmentMaker&) = default;
};

}  // namespace mote::render
