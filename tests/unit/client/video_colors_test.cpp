// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video/video_colors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/random.h"

namespace mote::client {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Planes {
    Planes(std::uint32_t width, std::uint32_t height, VideoChroma chroma)
        : half(chroma == VideoChroma::full ? 1 : 2),
          stride(width + 13),
          y(static_cast<std::size_t>(stride) * height, 7),
          u(y),
          v(y) {}
    VideoPlanes view() { return {{y.data(), u.data(), v.data()}, {stride, stride, stride}}; }

    std::ptrdiff_t half, stride;
    Bytes y, u, v;
};

Bytes noise(std::size_t pixels, unsigned seed) {
    test::Random random(seed);
    Bytes rgba;
    for (std::size_t i = 0; i < 4 * pixels; ++i) rgba.push_back(static_cast<std::uint8_t>(random.below(256)));
    return rgba;
}

double lumaOf(const std::uint8_t* p) {
    return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
}
double cbOf(const std::uint8_t* p) {
    return 128 + 224.0 / 255 * (p[2] - lumaOf(p)) / 1.8556;
}
double crOf(const std::uint8_t* p) {
    return 128 + 224.0 / 255 * (p[0] - lumaOf(p)) / 1.5748;
}

// Half a step, and what weights rounded to 2^-16 add: three of them, 255 times.
constexpr double nearest = 0.5 + 3 * 255.0 / 65536;

TEST(VideoColors, AreTheNearestOfTheStandard) {
    for (const std::uint32_t width : {1U, 15U, 16U, 200U}) {
        constexpr std::uint32_t height = 9;
        const auto rgba = noise(std::size_t{width} * height, width);
        Planes planes(width, height, VideoChroma::full);
        rgbaToVideo(width, rgba, VideoChroma::full, planes.view());
        for (std::uint32_t y = 0; y < height; ++y) {
            for (std::uint32_t x = 0; x < width; ++x) {
                const auto* pixel = rgba.data() + 4 * (y * width + x);
                const auto at = static_cast<std::size_t>(y * planes.stride + x);
                ASSERT_NEAR(planes.y[at], 16 + 219.0 / 255 * lumaOf(pixel), nearest);
                ASSERT_NEAR(planes.u[at], cbOf(pixel), nearest);
                ASSERT_NEAR(planes.v[at], crOf(pixel), nearest);
            }
            for (std::ptrdiff_t x = width; x < planes.stride; ++x) {
                ASSERT_EQ(planes.y[static_cast<std::size_t>(y * planes.stride + x)], 7)
                    << "padding was written";
            }
        }
    }
}

TEST(VideoColors, HalvedChromaLiesAtTheLeftColumn) {
    constexpr std::uint32_t width = 46, height = 8;
    const auto rgba = noise(std::size_t{width} * height, 3);
    Planes planes(width, height, VideoChroma::halved);
    rgbaToVideo(width, rgba, VideoChroma::halved, planes.view());
    const auto mean = [&](auto of, std::uint32_t x, std::uint32_t y) {
        const std::uint32_t left = x == 0 ? 0 : 2 * x - 1;
        double sum = 0;
        for (const std::uint32_t row : {2 * y, 2 * y + 1}) {
            const auto* p = rgba.data() + 4 * row * width;
            sum += of(p + 4 * left) + 2 * of(p + 8 * x) + of(p + 8 * x + 4);
        }
        return sum / 8;
    };
    for (std::uint32_t y = 0; y < height / 2; ++y) {
        for (std::uint32_t x = 0; x < width / 2; ++x) {
            const auto at = static_cast<std::size_t>(y * planes.stride + x);
            ASSERT_NEAR(planes.u[at], mean(cbOf, x, y), nearest);
            ASSERT_NEAR(planes.v[at], mean(crOf, x, y), nearest);
        }
    }
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            ASSERT_NEAR(planes.y[static_cast<std::size_t>(y * planes.stride + x)],
                        16 + 219.0 / 255 * lumaOf(rgba.data() + 4 * (y * width + x)), nearest);
        }
    }
}

TEST(VideoColors, GreyHasNoColourAndEndsAreTheRanges) {
    for (int grey = 0; grey < 256; ++grey) {
        const auto byte = static_cast<std::uint8_t>(grey);
        const Bytes rgba{byte, byte, byte, 0};
        Planes planes(1, 1, VideoChroma::full);
        rgbaToVideo(1, rgba, VideoChroma::full, planes.view());
        EXPECT_EQ(planes.u[0], 128);
        EXPECT_EQ(planes.v[0], 128);
        EXPECT_EQ(planes.y[0], std::lround(16 + 219.0 / 255 * grey));
    }
    const Bytes blue{0, 0, 255, 0}, red{255, 0, 0, 0};
    Planes planes(1, 1, VideoChroma::full);
    rgbaToVideo(1, blue, VideoChroma::full, planes.view());
    EXPECT_EQ(planes.u[0], 240);
    rgbaToVideo(1, red, VideoChroma::full, planes.view());
    EXPECT_EQ(planes.v[0], 240);
}

}  // namespace
}  // namespace mote::client
