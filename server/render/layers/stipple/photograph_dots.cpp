// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/photograph_dots.h"

#include <array>
#include <limits>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/mote_check.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/write_fields.h"
#include "server/render/layers/stipple/photograph_tone.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {

Dots photographDots(const PlaneTiles& tiles, const PixelMap& luminance, std::uint32_t width,
                    std::uint32_t height, const StippleStyle& style, const PhotographEffort& effort) {
    const double size = lengthOf(style, style.kDotPixelsFieldNumber);
    const glm::vec3 color(readColor(style.color()));
    const PhotographTone tone{lengthOf(style, style.kSpacingPixelsFieldNumber), size, style.gamma(),
                              denseInDark(style)};
    const auto wanted = wantedDensity(luminance, width, height, tone);
    Dots dots;
    for (const auto& dot : stipplePhotograph(tiles, wanted, {tone.fullDensity()}, effort)) {
        giveWay();
        dots.push_back({dot.place.x, dot.place.y, std::numeric_limits<double>::infinity(),
                        static_cast<float>(0.5 * size), static_cast<float>(style.opacity()), color});
    }
    return dots;
}

PixelMap luminanceOf(const Picture& picture) {
    MOTE_CHECK(picture.format == PixelFormat::srgb8);
    std::array<float, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i) {
        linear[i] = static_cast<float>(srgbToLinear(static_cast<double>(i) / 255.0));
    }
    constexpr std::size_t grain = std::size_t{1} << 16;
    auto values = listInTurns<float>(picture.pixels.size() / 4);
    forRangesInTurns(values.size(), grain, [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const std::uint8_t* pixel = &picture.pixels[4 * i];
            values[i] = 0.2126F * linear[pixel[0]] + 0.7152F * linear[pixel[1]] + 0.0722F * linear[pixel[2]];
        }
    });
    return {picture.width, picture.height, std::move(values)};
}

}  // namespace mote::render
