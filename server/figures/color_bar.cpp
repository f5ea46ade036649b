// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/color_bar.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "protocol/scene/srgb.h"

namespace mote::server {

void addColorBar(const Box& box, const PlotAxis& axis, const std::function<glm::dvec3(double)>& color,
                 const PlotLook& look, const Typeface& typeface, Marks& marks) {
    constexpr std::uint32_t shades = 256;
    ImageMark image{box, 1, shades, {}};
    for (std::uint32_t i = 0; i < shades; ++i) {
        const auto shade = linearToSrgb(glm::clamp(color((shades - i - 0.5) / shades), 0.0, 1.0));
        for (int c = 0; c < 3; ++c)
            image.rgba.push_back(static_cast<std::uint8_t>(std::lround(shade[c] * 255.0)));
        image.rgba.push_back(255);
    }
    marks.push_back(std::move(image));
    addFrame(box, look, marks);
    addAxis(axis, box, look, typeface, marks);
}

}  // namespace mote::server
