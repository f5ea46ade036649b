// SPDX-License-Identifier: GPL-3.0-or-later
//
// ColorBy: that points and volume take their colour from a column or derived quantity (docs/PICTURE.md,
// "Colour by a column"). A value; a parsed one is valid in itself (whether there is such a column, the
// dataset knows).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "protocol/mote.pb.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/error.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/transfer_function.h"

namespace mote {

struct ColorBy {
    static constexpr double opaque = 0.5;  ///< points of such an opacity hide those behind them
    enum class OfPixel {
        mean,     ///< the colour of the mean value of a pixel's points
        nearest,  ///< that of the nearest point's value
    };

    std::string column;
    std::optional<ValueRange> range;  ///< of the colour map; absent: 1% to 99% of the weight of all steps
    ColorMap colorMap = ColorMap::standard();
    std::optional<OfPixel> ofPixel;  ///< absent: that of the nearest where points are opaque

    bool ofNearest(const ParticlesStyle& style) const {
        if (ofPixel) return *ofPixel == OfPixel::nearest;
        return !style.opacityByPlot && style.pointOpacity >= opaque;
    }
    bool operator==(const ColorBy&) const = default;
};

/// Fills every default. Errors: no name, a range that does not ascend, a map or a word that is not known.
Result<ColorBy> parseColorBy(const proto::ColorBy& message);

/// Complete: parsing it gives the value again.
proto::ColorBy toProto(const ColorBy& colorBy);

void visitFields(ColorBy& colorBy, const ColorBy& other, FieldVisitor& visitor);

}  // namespace mote
