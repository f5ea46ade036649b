// SPDX-License-Identifier: GPL-3.0-or-later
//
// Carry: what a drawing takes over from the one before (docs/INK.md, "Films"): each place that was seen there
// too is found again by its depth and the motion of camera and layer. Pure; many threads work at it.
//
// LineMap: the lines of a picture, found by where they are; of each it is known whether it was drawn. A
// value; immutable.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/ink/ink_memory.h"
#include "server/render/ink/modalities.h"

namespace mote::render {

/// How a line was drawn before.
enum class LineBefore { unknown, left, drawn };

class LineMap {
  public:
    LineMap() = default;
    LineMap(const std::vector<InkLine>& drawn, const std::vector<InkLine>& left, std::uint32_t width,
            std::uint32_t height);

    /// What is known of the line that is most like one of a kind through a place in a direction (unit, or
    /// none); unknown where none is within a pixel or two. `alike`: what the depths of one line in two
    /// pictures differ by.
    LineBefore at(const PicturePlace& place, const glm::dvec2& direction, LineKind kind, double alike) const;

  private:
    struct Part {
        glm::vec2 from, to;
        float depthFrom, depthTo;
        LineBefore state;
        LineKind kind;
    };
    template <class Take>
    void eachPart(const Take& take) const;

    std::uint32_t columns_ = 0, rows_ = 0;  // of squares
    std::vector<Part> parts_;
    std::vector<std::uint32_t> begins_;  // of each square's parts; one more than squares
    std::vector<std::uint32_t> inside_;  // numbers of parts
};

class Carry {
  public:
    /// Refers to both.
    Carry(const Modalities& now, const InkCamera& camera, const InkMemory& before);

    /// How each segment of each line was drawn.
    std::vector<std::vector<LineBefore>> linesBefore(const std::vector<InkLine>& lines) const;
    /// What can be seen of hatches of before, where they lie on the surface now.
    std::vector<HatchStroke> hatches() const;
    /// Makes densities change slowly.
    void even(Raster<float>& density) const;

  private:
    LineBefore segmentBefore(const LinePoint& from, const LinePoint& to, LineKind kind) const;

    const Modalities& now_;
    const InkMemory& before_;
    PictureMotion motion_, forward_;
    LineMap lines_;               // of before
    Raster<std::uint32_t> from_;  // the pixel in which each was seen before, or nowhere
};

}  // namespace mote::render
