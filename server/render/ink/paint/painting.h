// SPDX-License-Identifier: GPL-3.0-or-later
//
// Regions that somebody painted on the surface by hand (docs/INK.md, "Regions painted by hand"): which pixels
// see them, and what becomes of the picture's own regions. Pure; the same on any number of threads.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/ink_memory.h"
#include "server/render/ink/modalities.h"
#include "server/render/ink/segments.h"

namespace mote::render {

/// What is painted, as a picture shows it.
class Painting {
  public:
    /// Nothing is painted.
    Painting() = default;
    /// `segments`: of the picture, none where nobody asks for them; those of `regions` come beside them, or
    /// in their place. A pixel belongs to a region if the place that it sees lies within the radius of one of
    /// its dabs, or to a whole one with all of its segment; to the last of several. If `stop` is requested
    /// meanwhile, some do not.
    Painting(const Modalities& modalities, const InkCamera& camera, const std::vector<PaintedRegion>& regions,
             Segments& segments, const std::stop_token& stop);

    /// Whether any region is drawn so.
    bool has(RegionFill fill) const;
    RegionFill fillAt(std::size_t pixel) const {
        return region_.values.empty() || region_.values[pixel] == 0 ? RegionFill::usual
                                                                    : fills_[region_.values[pixel] - 1U];
    }

  private:
    Raster<std::uint8_t> region_;    // its number and 1; 0: none
    std::vector<RegionFill> fills_;  // of regions
};

}  // namespace mote::render
