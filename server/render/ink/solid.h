// SPDX-License-Identifier: GPL-3.0-or-later
//
// Solid ink (the dissertation's section 2.3.7.2): where a picture is too complex for lines and hatches, what
// is dark is inked with a brush and the rest stays paper: a blurred threshold. Pure.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/contour.h"
#include "server/render/ink/ink_line.h"
#include "server/render/ink/modalities.h"
#include "server/render/ink/paint/painting.h"

namespace mote::render {

/// How a pixel is drawn: with lines and hatches; or, of a complex region, not at all; or inked solid.
enum class Ground : std::uint8_t { simple, paper, solid };

struct SolidInk {
    Raster<Ground> ground;
    std::vector<Outline> outlines;  ///< of what is solid
};

/// What a drawing of solid ink is made from: pictures of one size.
struct SolidScene {
    const Modalities& modalities;
    const Raster<float>& wanted;         ///< share of each pixel that ink should cover
    const Raster<float>& cover;          ///< what lines would cover of each pixel
    const Painting* painting = nullptr;  ///< says of some pixels whether they are inked; or null

    RegionFill fillAt(std::size_t pixel) const {
        return painting == nullptr ? RegionFill::usual : painting->fillAt(pixel);
    }
};

/// `reading`: pixels, by which cover is blurred; what is smaller than its square is no region and no hole in
/// one. Where `stop` is
/// requested meanwhile something is missing.
SolidInk solidInk(const SolidScene& scene, const SolidStyle& style, double reading,
                  const std::stop_token& stop);

struct BesideOptions {
    double leastStep = 1.0;  ///< of lines (LinePoint::step), above which they may be drawn on paper, too
    double shortest = 0.0;   ///< pixels; what is shorter of a line that is cut is left out
};

/// What of lines lies in simple regions, and what may be drawn on paper in complex ones. A line lies where
/// the nearest pixel around it does, as the surface that it bounds is seen there. If `stop` is requested
/// meanwhile some are missing.
std::vector<InkLine> linesBeside(const std::vector<InkLine>& lines, const Raster<Ground>& ground,
                                 const Modalities& modalities, const BesideOptions& options,
                                 const std::stop_token& stop);

}  // namespace mote::render
