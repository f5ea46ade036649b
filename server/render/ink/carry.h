// SPDX-License-Identifier: GPL-3.0-or-later
//
// Carry: what a drawing takes over from the one before (docs/INK.md, "Films"): each place that was seen there
// too is found again by its depth and the motion of camera and layer. Pure; many threads work at it.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/ink/ink_memory.h"
#include "server/render/ink/line_map.h"
#include "server/render/ink/modalities.h"

namespace mote::render {

class Carry {
  public:
    /// Refers to both.
    Carry(const Modalities& now, const InkCamera& camera, const InkMemory& before);

    /// How each segment of each line was drawn.
    std::vector<std::vector<LineBefore>> linesBefore(const std::vector<InkLine>& lines) const;
    /// Regions as before where they still go with what is seen there; where they do not, or nothing was seen
    /// before, as they are found anew.
    Segments regions(const Segments& found, std::size_t leastPixels, const std::stop_token& stop) const;
    /// Strokes of regions that were there before lie where they lay on the surface, and turn slowly to what
    /// is asked for.
    std::vector<HatchAxes> axes(const Segments& regions, const std::vector<HatchAxes>& asked) const;
    /// Makes densities change slowly.
    void even(Raster<float>& density) const;

  private:
    LineBefore segmentBefore(const LinePoint& from, const LinePoint& to) const;

    const Modalities& now_;
    const InkMemory& before_;
    PictureMotion motion_;
    LineMap lines_;               // of before
    Raster<std::uint32_t> from_;  // the pixel in which each was seen before, or nowhere
};

}  // namespace mote::render
