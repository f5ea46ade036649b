// SPDX-License-Identifier: GPL-3.0-or-later
//
// Annotations: what a picture says beside what it shows: axes, bars, words (docs/PICTURE.md, "Annotations"):
// their message, whose fields are checked. Pure functions.
#pragma once

#include <cstdint>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote {

/// Errors: a number out of range, a title that is too long or of several lines.
Status checkAnnotations(const proto::Annotations& message);

/// The size of their font in a picture of so many pixels, of a view of that scale.
double fontPixels(const proto::Annotations& annotations, std::uint32_t width, std::uint32_t height,
                  double scale);

/// Those of a picture of so many pixels and a view of that scale: as large as they are there, whatever the
/// scale.
proto::Annotations inPixels(proto::Annotations annotations, std::uint32_t width, std::uint32_t height,
                            double scale);

}  // namespace mote
