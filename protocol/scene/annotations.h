// SPDX-License-Identifier: GPL-3.0-or-later
//
// Annotations: what a picture says beside what it shows: axes, bars, words (docs/PICTURE.md, "Annotations").
// A value; a parsed one is valid.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/length_scale.h"

namespace mote {

struct Annotations {
    bool axes = false;      ///< a box with ticks around each particle plot
    bool colorBar = false;  ///< for each layer that has a colour map
    bool scaleBar = false;  ///< where layers lie in the world's units
    bool labels = false;    ///< dataset, step, time, and how many particles a selection holds
    std::string title;
    ScreenLength fontPoints = ScreenLength::usual(9.0);
    std::optional<double> printWidth;  ///< mm, of the picture; absent: 96 pixels an inch, scaled
    std::optional<glm::dvec3> color;   ///< linear RGB; absent: what stands out from the background

    /// The size of the font in a picture of so many pixels, of a view of that scale.
    double fontPixels(std::uint32_t width, std::uint32_t height, double scale) const;
    bool operator==(const Annotations&) const = default;
};

/// Fills every default. Errors: a number out of range, a title that is too long or of several lines.
Result<Annotations> parseAnnotations(const proto::Annotations& message);

/// Complete: parsing it gives the value again, the colour to rounding.
proto::Annotations toProto(const Annotations& annotations);

/// Those of a picture of so many pixels and a view of that scale: as large as they are there, whatever the
/// scale.
Annotations inPixels(const Annotations& annotations, std::uint32_t width, std::uint32_t height, double scale);

/// At a share of the way between those of two views, more than 0 and less than 1: what has nothing in between
/// is as in the first.
std::optional<Annotations> mixAnnotations(const std::optional<Annotations>& from,
                                          const std::optional<Annotations>& to, double share);

}  // namespace mote
