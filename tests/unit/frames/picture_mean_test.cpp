// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/picture_mean.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <vector>

#include "protocol/scene/srgb.h"
#include "tests/support/random.h"

namespace mote::server {
namespace {

using render::Picture, render::PixelFormat;

constexpr std::uint32_t meanWidth = 64, meanHeight = 32;

/// Any finite light, most of it below 1, alpha 1.
Picture anyPicture(test::Random& random) {
    Picture picture{meanWidth, meanHeight, PixelFormat::linearHalf, {}, random.below(100)};
    picture.pixels.resize(std::size_t{8} * meanWidth * meanHeight);
    for (std::size_t i = 0; i < std::size_t{4} * meanWidth * meanHeight; ++i) {
        const double value = random.chance(0.1) ? 0.0 : random.magnitude(-20, 1);
        const auto half = glm::packHalf1x16(i % 4 == 3 ? 1.0F : static_cast<float>(value));
        std::memcpy(picture.pixels.data() + 2 * i, &half, 2);
    }
    return picture;
}

double valueOf(const Picture& picture, std::size_t index) {
    std::uint16_t half = 0;
    std::memcpy(&half, picture.pixels.data() + 2 * index, 2);
    return glm::unpackHalf1x16(half);
}

/// As sRGB says, not rounded.
double encoded(double linear) {
    return 255.0 * std::clamp(linearToSrgb(linear), 0.0, 1.0);
}

TEST(PictureMean, IsTheMeanInLinearLight) {
    test::Random random(71);
    for (int tries = 0; tries < 20; ++tries) {
        const std::vector<Picture> pictures{anyPicture(random), anyPicture(random), anyPicture(random)};
        const std::size_t count = 2 + random.below(2);
        const double first = random.unit(), second = count == 2 ? 1.0 - first : (1.0 - first) * random.unit();
        const double weights[] = {first, second, 1.0 - first - second};
        for (const auto format : {PixelFormat::srgb8, PixelFormat::linearHalf}) {
            PictureMean mean;
            for (std::size_t i = 0; i < count; ++i) mean.add(pictures[i], weights[i]);
            EXPECT_EQ(mean.bytes(), 2 * pictures[0].pixels.size());
            const auto picture = mean.take(format);
            EXPECT_EQ(mean.bytes(), 0U);
            ASSERT_EQ(picture.pixels.size(),
                      std::size_t{render::bytesPerPixel(format)} * meanWidth * meanHeight);
            EXPECT_EQ(picture.format, format);
            for (std::size_t i = 0; i < std::size_t{4} * meanWidth * meanHeight; ++i) {
                double expected = 0.0;
                for (std::size_t k = 0; k < count; ++k) expected += weights[k] * valueOf(pictures[k], i);
                // Halves have 11 bits, and the least are 2^-24 apart; each join rounds once.
                const double slack = (count - 1) * (expected * 0x1p-11 + 0x1p-24);
                if (format == PixelFormat::linearHalf) {
                    ASSERT_NEAR(valueOf(picture, i), expected, slack);
                    continue;
                }
                const double least = encoded(expected - (count - 2) * slack) - 0.501;
                ASSERT_GE(picture.pixels[i], least);
                ASSERT_LE(picture.pixels[i], encoded(expected + (count - 2) * slack) + 0.501);
                ASSERT_TRUE(i % 4 != 3 || picture.pixels[i] == 255);
            }
        }
    }
}

TEST(PictureMean, OfOnePictureTwiceIsThatPicture) {
    test::Random random(72);
    const auto picture = anyPicture(random);
    PictureMean mean;
    mean.add(picture, 0.25);
    mean.add(picture, 0.75);
    const auto same = mean.take(PixelFormat::linearHalf);
    EXPECT_EQ(same.pixels, picture.pixels);
    EXPECT_EQ(same.pointsDrawn, 2 * picture.pointsDrawn);
}

}  // namespace
}  // namespace mote::server
