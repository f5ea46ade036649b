// SPDX-License-Identifier: GPL-3.0-or-later
//
// Page: the sheet that a vector picture lies on, and how its dots are put there. A value; a parsed one is
// valid.
#pragma once

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/length_scale.h"

namespace mote {

struct Page {
    static constexpr double pixelSize =
        inchInMillimeters / 96.0;              ///< mm, where no size of the sheet is given
    static constexpr double maxSide = 5000.0;  ///< mm, of the sheet

    proto::Page::Format format = proto::Page::SVG;
    double width = 0.0;    ///< mm; 0: as wide as the picture asks for
    double height = 0.0;   ///< mm; 0: as high as the picture asks for
    double margin = 0.0;   ///< mm, on each side
    double dot = 0.0;      ///< mm, diameter of the largest dots; 0: as the picture has them
    bool plotter = false;  ///< each dot a tiny stroke of a pen, and all strokes in the order of a short tour

    bool operator==(const Page&) const = default;
};

/// Errors: a format that is not known, a number out of range, margins that leave nothing.
Result<Page> parsePage(const proto::Page& message);

}  // namespace mote
