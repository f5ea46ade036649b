// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/pixel_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace mote::render {
namespace {

constexpr std::uint32_t width = 37, height = 23;

std::vector<float> randomValues() {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    std::vector<float> values(width * height);
    for (auto& value : values) value = unit(random);
    return values;
}

/// The mean over a rectangle, pixel by pixel.
double slowMean(const std::vector<float>& values, double x0, double y0, double x1, double y1) {
    double sum = 0.0;
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const double across = std::min(x1, x + 1.0) - std::max<double>(x0, x);
            const double down = std::min(y1, y + 1.0) - std::max<double>(y0, y);
            if (across > 0.0 && down > 0.0) sum += across * down * values[y * width + x];
        }
    }
    return sum / ((x1 - x0) * (y1 - y0));
}

TEST(PixelMap, meansOverSquaresAreExact) {
    const auto values = randomValues();
    const PixelMap map(width, height, values);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 500; ++i) {
        const double x = unit(random) * width;
        const double y = unit(random) * height;
        const double half = 0.5 * (1.0 + 12.0 * unit(random));
        const double expected =
            slowMean(values, std::max(x - half, 0.0), std::max(y - half, 0.0),
                     std::min<double>(x + half, width), std::min<double>(y + half, height));
        // Sums up to 851 in doubles, of which a part of a pixel is the least that is looked at.
        EXPECT_NEAR(map.mean(x, y, 2.0 * half), expected, 1e-9);
    }
    EXPECT_NEAR(map.total(), slowMean(values, 0, 0, width, height) * width * height, 1e-9);
}

TEST(PixelMap, outsideIsAsAtTheEdge) {
    const PixelMap map(width, height, randomValues());
    EXPECT_EQ(map.mean(-50.0, 7.5, 1.0), map.mean(0.0, 7.5, 1.0));
    EXPECT_EQ(map.mean(1e6, 1e6, 3.0), map.mean(width, height, 3.0));
    EXPECT_NEAR(map.mean(10.0, 10.0, 1e6), map.total() / (width * height), 1e-12);
}

TEST(PixelMap, ofOnePixel) {
    const PixelMap map(1, 1, {0.25F});
    EXPECT_DOUBLE_EQ(map.mean(0.5, 0.5, 0.1), 0.25);
    EXPECT_DOUBLE_EQ(map.mean(-3.0, 9.0, 100.0), 0.25);
}

}  // namespace
}  // namespace mote::render
