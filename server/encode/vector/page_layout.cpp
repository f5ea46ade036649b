// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/page_layout.h"

#include <algorithm>
#include <limits>

namespace mote::server {

PageLayout layOut(const Page& page, std::uint32_t width, std::uint32_t height) {
    const double margins = 2.0 * page.margin;
    PageLayout layout;
    layout.scale = std::numeric_limits<double>::max();
    if (page.width > 0.0) layout.scale = (page.width - margins) / width;
    if (page.height > 0.0) layout.scale = std::min(layout.scale, (page.height - margins) / height);
    if (page.width == 0.0 && page.height == 0.0) layout.scale = Page::pixelSize;
    layout.width = page.width > 0.0 ? page.width : layout.scale * width + margins;
    layout.height = page.height > 0.0 ? page.height : layout.scale * height + margins;
    layout.left = 0.5 * (layout.width - layout.scale * width);
    layout.top = 0.5 * (layout.height - layout.scale * height);
    return layout;
}

}  // namespace mote::server
