// SPDX-License-Identifier: GPL-3.0-or-later
//
// A picture without its background looks as it is shown wherever it is laid on what it was shown on.
#include "client/view/files/picture_keeper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>

#include "protocol/scene/srgb.h"
#include "tests/support/temp_dir.h"

namespace mote::client {
namespace {

/// The half float next to a value of 0 to 1.
std::uint16_t halfOf(double value) {
    if (value < std::ldexp(1.0, -14)) return static_cast<std::uint16_t>(std::lround(std::ldexp(value, 24)));
    int exponent = 0;
    const double fraction = std::frexp(value, &exponent);  // 0.5 to 1
    return static_cast<std::uint16_t>(((exponent + 14) << 10) + std::lround(2048.0 * fraction) - 1024);
}

/// Matter of a colour (linear, times its opacity) that lets so much of the background through.
struct Matter {
    glm::dvec3 color;
    double through;

    glm::dvec3 on(const glm::dvec3& background) const { return color + through * background; }
};

FramePixels linearOf(const std::vector<Matter>& matter, const glm::dvec3& background) {
    FramePixels pixels{static_cast<std::uint32_t>(matter.size()), 1, proto::LINEAR_HALF, {}};
    for (const auto& each : matter) {
        const auto light = each.on(background);
        for (const double value : {light.x, light.y, light.z, 1.0}) {
            const auto bits = halfOf(value);
            pixels.bytes.push_back(static_cast<std::uint8_t>(bits));
            pixels.bytes.push_back(static_cast<std::uint8_t>(bits >> 8));
        }
    }
    return pixels;
}

FramePixels shownOf(const std::vector<Matter>& matter, const glm::dvec3& background) {
    FramePixels pixels{static_cast<std::uint32_t>(matter.size()), 1, proto::SRGB8, {}};
    for (const auto& each : matter) {
        const auto shown = linearToSrgb(each.on(background));
        for (const double value : {shown.x, shown.y, shown.z, 1.0})
            pixels.bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0 * value)));
    }
    return pixels;
}

const std::vector<Matter> matters{{glm::dvec3(0.0), 1.0},       {glm::dvec3(0.5), 0.5},
                                  {glm::dvec3(0.8), 0.0},       {{0.3, 0.1, 0.02}, 0.7},
                                  {{0.001, 0.002, 0.0}, 0.998}, {{0.0, 0.0, 0.0}, 0.25},
                                  {{0.9, 0.4, 0.05}, 0.1},      {{0.02, 0.02, 0.02}, 0.0}};

class WithoutBackground : public testing::TestWithParam<glm::dvec3> {};

TEST_P(WithoutBackground, IsThePictureOnItsOwnBackground) {
    const auto background = GetParam(), other = otherBackground(background);
    const auto shown = shownOf(matters, background), linear = linearOf(matters, background),
               again = linearOf(matters, other);
    const auto rgba = withoutBackground({shown, linear, again, background, other});
    EXPECT_EQ(rgba[3], 0);
    EXPECT_EQ(rgba[4 * 2 + 3], 255);
    const auto ground = glm::round(linearToSrgb(background) * 255.0);
    for (std::size_t i = 0; i < matters.size(); ++i) {
        const double opacity = rgba[4 * i + 3] / 255.0;
        for (int c = 0; c < 3; ++c) {
            const double laid =
                opacity * rgba[4 * i + static_cast<std::size_t>(c)] + (1.0 - opacity) * ground[c];
            EXPECT_NEAR(laid, shown.bytes[4 * i + static_cast<std::size_t>(c)], 1.01)
                << "matter " << i << ", " << c;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Backgrounds, WithoutBackground,
                         testing::Values(glm::dvec3(0.0), glm::dvec3(1.0), glm::dvec3(0.15, 0.02, 0.3),
                                         glm::dvec3(0.5), glm::dvec3(0.0, 0.3, 0.9)));

/// What is grey has one opacity for all three colours.
TEST(WithoutBackgroundOfGrey, IsThePictureOnWhiteToo) {
    const glm::dvec3 black(0.0), other = otherBackground(black);
    const std::vector<Matter> grey{{glm::dvec3(0.5), 0.5}, {glm::dvec3(0.1), 0.3}, {glm::dvec3(0.0), 0.6}};
    const auto rgba =
        withoutBackground({shownOf(grey, black), linearOf(grey, black), linearOf(grey, other), black, other});
    const auto onWhite = shownOf(grey, glm::dvec3(1.0));
    for (std::size_t at = 0; at < rgba.size(); at += 4) {
        const double opacity = rgba[at + 3] / 255.0;
        EXPECT_NEAR(opacity * rgba[at] + 255.0 * (1.0 - opacity), onWhite.bytes[at], 1.6);
    }
}

TEST(OtherBackground, IsAsLightOrAsDark) {
    for (double light = 0.0; light <= 1.0; light += 0.01) {
        for (const auto& color :
             {glm::dvec3(light), glm::dvec3(light, 0.0, 0.0), glm::dvec3(0.2, light, 1.0)}) {
            const auto other = otherBackground(color);
            EXPECT_EQ(isLight(color), isLight(other));
            EXPECT_GT(glm::distance(color, other), 0.1);
        }
    }
}

TEST(PictureKeeper, WaitsForAllPicturesOfAGoal) {
    const test::TempDir folder;
    std::vector<proto::View> asked;
    std::vector<proto::PixelFormat> formats;
    PictureKeeper keeper([&](proto::View view, const ViewRequest& request) {
        asked.push_back(std::move(view));
        formats.push_back(request.format);
        EXPECT_TRUE(request.queued && request.finalOnly);
        return std::uint64_t{10} + asked.size();
    });
    proto::View view;
    view.set_width(8);
    view.set_height(1);
    ASSERT_TRUE(keeper.want(view, {folder / "clear.png", false}).ok());
    ASSERT_EQ(asked.size(), 3U);
    EXPECT_EQ(formats, (std::vector{proto::SRGB8, proto::LINEAR_HALF, proto::LINEAR_HALF}));
    EXPECT_NE(asked[1].background(0), asked[2].background(0));
    const glm::dvec3 black(0.0), other = otherBackground(black);
    const auto frameOf = [](std::uint64_t id, FramePixels pixels) {
        ReceivedFrame frame;
        frame.message.set_view_id(id);
        frame.pixels = std::move(pixels);
        return frame;
    };
    EXPECT_FALSE(keeper.take(frameOf(9, {})));
    EXPECT_EQ(keeper.take(frameOf(13, linearOf(matters, other))), "");
    EXPECT_EQ(keeper.take(frameOf(11, shownOf(matters, black))), "");
    const auto said = keeper.take(frameOf(12, linearOf(matters, black)));
    EXPECT_NE(said.value_or("").find("without background"), std::string::npos) << said.value_or("");
    EXPECT_TRUE(std::filesystem::exists(folder / "clear.png"));
    EXPECT_FALSE(keeper.takeFailure(12));
    ASSERT_TRUE(keeper.want(view, {folder / "other.png", true}).ok());
    EXPECT_TRUE(keeper.takeFailure(14));
    EXPECT_FALSE(keeper.take(frameOf(14, shownOf(matters, black))));
}

}  // namespace
}  // namespace mote::client
