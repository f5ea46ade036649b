// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cstring>
#include <glm/gtc/packing.hpp>
#include <string>

#include "protocol/scene/srgb.h"
#include "server/encode/draw_annotations.h"
#include "server/encode/vector/vector_drawing.h"

namespace mote::server {
namespace {

/// A grey square in the middle half of a view of 40 x 20, half of it shining through, and a word.
Marks someMarks() {
    const Ink ink{glm::dvec3(0.75), 0.5};
    return {AreaMark{{{10, 5}, {30, 5}, {30, 15}, {10, 15}}, ink},
            TextMark{upright("a<&"), {1, 5}, 4.0, {0.0, 1.0}, 0.3, {glm::dvec3(1.0)}}};
}

render::Picture black(std::uint32_t width, std::uint32_t height, render::PixelFormat format) {
    return {width, height, format,
            std::vector<std::uint8_t>(std::size_t{width} * height * render::bytesPerPixel(format), 0)};
}

TEST(Annotations, lieWhereTheViewHasThemInPicturesOfFewerPixels) {
    for (const std::uint32_t scale : {1U, 2U, 4U}) {
        auto picture = black(40 / scale, 20 / scale, render::PixelFormat::srgb8);
        ASSERT_TRUE(drawAnnotations({someMarks()[0]}, 40, 20, picture).ok());
        const auto at = [&](std::uint32_t x, std::uint32_t y) {
            return picture.pixels[4 * (std::size_t{y / scale} * picture.width + x / scale)];
        };
        EXPECT_NEAR(at(20, 10), 96, 1);  // half of 0.75 of 255: mixed as encoded
        EXPECT_EQ(at(4, 10), 0);
        EXPECT_EQ(at(36, 10), 0);
    }
}

TEST(Annotations, ofALinearPictureAreMixedInLinearLight) {
    auto picture = black(40, 20, render::PixelFormat::linearHalf);
    ASSERT_TRUE(drawAnnotations({someMarks()[0]}, 40, 20, picture).ok());
    std::uint16_t bits = 0;
    std::memcpy(&bits, &picture.pixels[8 * (10 * 40 + 20)], sizeof bits);
    // Colour and opacity have 8 bits, the former times the latter.
    EXPECT_NEAR(static_cast<double>(glm::unpackHalf1x16(bits)), 0.5 * srgbToLinear(0.75), 0.01);
}

TEST(Annotations, areShapesInEveryDocument) {
    for (const auto format : {proto::Page::SVG, proto::Page::EPS, proto::Page::PDF}) {
        VectorDrawing drawing{40, 20, glm::vec3(0.0F), std::nullopt, {}};
        Page page;
        page.format = format;
        const auto without = drawVector(drawing, page);
        drawing.annotations = std::make_shared<const Marks>(someMarks());
        const auto with = drawVector(drawing, page), again = drawVector(drawing, page);
        ASSERT_TRUE(with.ok() && without.ok() && again.ok());
        EXPECT_EQ(*with, *again);
        EXPECT_GT(with->size(), without->size() + 50);
        const std::string text(with->begin(), with->end());
        // Nothing was made an image for its opacity.
        EXPECT_TRUE(format != proto::Page::EPS || text.find("ImageType") == std::string::npos);
        const bool named = text.find("aria-label=\"a&lt;&amp;\"") != std::string::npos;
        EXPECT_EQ(named, format == proto::Page::SVG);
    }
}

}  // namespace
}  // namespace mote::server
