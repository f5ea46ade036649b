// SPDX-License-Identifier: GPL-3.0-or-later
//
// HistogramPicture: a histogram of two columns as colours, and its sums along both of them. Pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "client/shared/numbers.h"
#include "protocol/scene/color_map.h"

namespace mote::client {

struct HistogramPicture {
    std::uint32_t width = 0;           ///< bins of the first column
    std::uint32_t height = 0;          ///< bins of the second
    std::vector<std::uint8_t> pixels;  ///< RGBA, sRGB-encoded; the second column's last bin on top
};

/// Bins without weight are transparent, the others have the map's colours up to that of the greatest: by the
/// logarithm between the least and the greatest, or in proportion. Below zero counts as nothing.
HistogramPicture pictureOf(const StepHistogram& histogram, const ColorMap& map, bool logScale);

/// The weight in each bin of one of the two columns.
std::vector<double> marginalOf(const StepHistogram& histogram, std::size_t column);

}  // namespace mote::client
