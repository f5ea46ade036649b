// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/blank_picture.h"

#include <cstring>
#include <glm/common.hpp>
#include <glm/packing.hpp>
#include <glm/vec4.hpp>

#include "protocol/scene/srgb.h"

namespace mote::render {

std::array<std::uint8_t, 8> blankPixel(const glm::dvec3& background, PixelFormat format) {
    std::array<std::uint32_t, 2> words{};
    if (format == PixelFormat::linearHalf) {
        words = {glm::packHalf2x16(glm::vec2(background.x, background.y)),
                 glm::packHalf2x16(glm::vec2(background.z, 1.0))};
    } else {
        const glm::dvec3 encoded = glm::clamp(linearToSrgb(background), 0.0, 1.0);
        words[0] = glm::packUnorm4x8(glm::vec4(encoded, 1.0));
    }
    std::array<std::uint8_t, 8> bytes{};
    std::memcpy(bytes.data(), words.data(), bytes.size());
    return bytes;
}

Picture blankPicture(const FramePlan& plan, PixelFormat format) {
    Picture picture{.width = plan.width, .height = plan.height, .format = format, .pixels = {}};
    const auto blank = blankPixel(plan.background, format);
    const std::size_t size = bytesPerPixel(format);
    picture.pixels.resize(std::size_t{plan.width} * plan.height * size);
    for (std::size_t at = 0; at < picture.pixels.size(); at += size)
        std::memcpy(picture.pixels.data() + at, blank.data(), size);
    return picture;
}

}  // namespace mote::render
