// SPDX-License-Identifier: GPL-3.0-or-later
//
// LineMap: the lines of a picture, found by where they are; of each it is known whether it was drawn. A
// value; immutable.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "server/render/ink/ink_camera.h"
#include "server/render/ink/ink_line.h"

namespace mote::render {

/// How a line was drawn before.
enum class LineBefore { unknown, left, drawn };

class LineMap {
  public:
    LineMap() = default;
    LineMap(const std::vector<InkLine>& drawn, const std::vector<InkLine>& left, std::uint32_t width,
            std::uint32_t height);

    /// Of the line that is most like one through a place in a direction (unit, or none); unknown where none
    /// is within a pixel or two. `alike`: what the depths of one line in two pictures differ by.
    LineBefore at(const PicturePlace& place, const glm::dvec2& direction, double alike) const;

  private:
    struct Part {
        glm::vec2 from, to;
        float depthFrom, depthTo;
        LineBefore state;
    };
    template <class Take>
    void eachPart(const Take& take) const;

    std::uint32_t columns_ = 0, rows_ = 0;  // of squares
    std::vector<Part> parts_;
    std::vector<std::uint32_t> begins_;  // of each square's parts; one more than squares
    std::vector<std::uint32_t> inside_;  // numbers of parts
};

}  // namespace mote::render
