// SPDX-License-Identifier: GPL-3.0-or-later
//
// FigureStyle: how a figure of numbers looks (docs/NUMBERS.md, "Figures"). A value; a parsed one is valid in
// itself (whether there are such columns or statistics, the dataset knows).
#pragma once

#include <cstdint>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/color_map.h"

namespace mote {

struct FigureStyle {
    static constexpr int mostStatistics = 16;

    proto::FigureQuery::Format format = proto::FigureQuery::SVG;
    double width = 85.0;    ///< mm, as it is printed
    double height = 63.75;  ///< mm
    double fontPoints = 8.0;
    double dotsPerInch = 200.0;  ///< of a PNG
    bool dark = false;           ///< white on black
    bool logScale = false;       ///< of the counts
    bool marginals = false;
    bool ellipse = false;
    ColorMap colorMap = ColorMap::standard();
    std::string title;

    /// Of a PNG.
    std::uint32_t pixelWidth() const;
    std::uint32_t pixelHeight() const;
};

/// Fills every default. Errors: no format; neither a histogram of one or two axes nor 1 to 16 statistics, or
/// both; a number out of range; letters too large for the figure, or more pixels than a view may have; a
/// colour map that is not known; what is of two axes or of counts and is asked of something else; a title as
/// of annotations.
Result<FigureStyle> parseFigureStyle(const proto::FigureQuery& message);

}  // namespace mote
