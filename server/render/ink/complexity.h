// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where a picture holds so many lines that they run together (the dissertation's section 2.3.5.1). Pure.
#pragma once

#include <stop_token>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/ink/raster.h"

namespace mote::render {

/// The share of each pixel that lines of a width cover, as if they did not lie over one another: above 1
/// where they do.
Raster<float> coverOf(const std::vector<InkLine>& lines, std::uint32_t columns, std::uint32_t rows,
                      double width);

/// Blurred by about a Gaussian of a standard deviation, along ways on which the depth makes no step: from a
/// pixel to the next of at most a part of the extent. (Gastal and Oliveira 2011, Domain Transform for
/// Edge-Aware Image and Video Processing, recursive filtering.) If `stop` is requested meanwhile, it is
/// not blurred everywhere.
Raster<float> blurredWithin(const Raster<float>& picture, const Raster<float>& depth, double extent,
                            double deviation, const std::stop_token& stop = {});

}  // namespace mote::render
