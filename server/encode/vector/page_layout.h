// SPDX-License-Identifier: GPL-3.0-or-later
//
// PageLayout: where a picture lies on its sheet: as large as the margins let it, in the middle. A value;
// pure.
#pragma once

#include <cstdint>

#include "protocol/scene/page.h"

namespace mote::server {

struct PageLayout {
    double width = 0.0;   ///< of the sheet, mm
    double height = 0.0;  ///< of the sheet, mm
    double scale = 0.0;   ///< of the picture, mm a pixel
    double left = 0.0;    ///< of the picture, mm
    double top = 0.0;     ///< of the picture, mm

    double x(double pixels) const { return left + scale * pixels; }  ///< mm from the sheet's left edge
    double y(double pixels) const { return top + scale * pixels; }   ///< mm from its upper edge
};

/// `width` and `height` of the picture in pixels, at least 1. Where only one side of the sheet is given, the
/// other follows from the picture.
PageLayout layOut(const Page& page, std::uint32_t width, std::uint32_t height);

}  // namespace mote::server
