// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointValues: a number of each point of a step, by which it is coloured (docs/PICTURE.md, "Colour by a
// column"). Values; shared by plans.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "protocol/scene/color_map.h"
#include "protocol/scene/transfer_function.h"

namespace mote::render {

/// A point's value, told as a share of a colour map's range in 65535 even steps.
using ValueCode = std::uint16_t;
inline constexpr ValueCode noValue = 65535;
inline constexpr ValueCode greatestValue = 65534;

/// What lies beyond the range counts as its end, NaN as no value; in a range of one value that is the middle.
inline ValueCode codeOf(double value, const ValueRange& range) {
    if (std::isnan(value)) return noValue;
    const double width = range.high - range.low;
    if (!(width > 0.0)) return value < range.low ? 0 : value > range.high ? greatestValue : greatestValue / 2;
    const double share = (value - range.low) / width;
    return static_cast<ValueCode>(std::lround(greatestValue * std::fmin(std::fmax(share, 0.0), 1.0)));
}

struct PointValues {
    std::vector<ValueCode> codes;  ///< by point of the step; or:
    bool byLeaf = false;           ///< by leaf of the step, the same for all its points
    bool complete = true;          ///< each has a value

    std::uint64_t bytes() const { return codes.capacity() * sizeof(ValueCode); }
};

/// How points take their colour from their values.
struct PointColors {
    std::shared_ptr<const PointValues> values;  ///< not null; of all points of the step
    ColorMap map = ColorMap::standard();
    bool nearest = false;  ///< that of a pixel's nearest point; or of the mean of all
};

}  // namespace mote::render
