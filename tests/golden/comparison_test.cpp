// SPDX-License-Identifier: GPL-3.0-or-later
//
// The comparator: it must see what a person would call wrong, and nothing else.
#include "tests/golden/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mote::test {
namespace {

Image gray(std::uint32_t width, std::uint32_t height, std::uint8_t value) {
    Image image{width, height, std::vector<std::uint8_t>(std::size_t{4} * width * height, value)};
    for (std::size_t i = 3; i < image.pixels.size(); i += 4) image.pixels[i] = 255;
    return image;
}

/// As large as the golden pictures, dark, with one point of half opacity.
Image withPoint(std::uint32_t column, std::uint32_t row) {
    Image image = gray(320, 180, 0);
    std::fill_n(&image.pixels[4 * (std::size_t{row} * 320 + column)], 3, std::uint8_t{188});
    return image;
}

TEST(Comparison, EqualPicturesAreEqual) {
    const auto result = compare(withPoint(100, 50), withPoint(100, 50));
    EXPECT_TRUE(result.within({})) << result.toString();
    EXPECT_TRUE(std::isinf(result.psnr));
    EXPECT_EQ(result.closeShare, 1.0);
    EXPECT_EQ(result.worst, 0);
}

TEST(Comparison, AWrongSizeFails) {
    EXPECT_FALSE(compare(gray(320, 180, 0), gray(320, 181, 0)).within({}));
    EXPECT_FALSE(compare(gray(180, 320, 0), gray(320, 180, 0)).within({}));
    Image shortened = gray(320, 180, 0);
    shortened.pixels.pop_back();
    EXPECT_FALSE(compare(shortened, gray(320, 180, 0)).within({}));
}

TEST(Comparison, AnEmptyImageFails) {
    EXPECT_FALSE(compare(Image{}, gray(320, 180, 0)).within({}));
    EXPECT_FALSE(compare(gray(320, 180, 0), Image{}).within({}));
    EXPECT_FALSE(compare(Image{}, Image{}).within({}));
}

TEST(Comparison, AMovedPointFails) {
    const auto result = compare(withPoint(101, 50), withPoint(100, 50));
    EXPECT_FALSE(result.within({})) << result.toString();
    EXPECT_EQ(result.worst, 188);
    EXPECT_EQ(result.row, 50U);
    EXPECT_EQ(result.column, 100U);
}

TEST(Comparison, AMissingPointFails) {
    EXPECT_FALSE(compare(gray(320, 180, 0), withPoint(100, 50)).within({}));
    EXPECT_FALSE(compare(withPoint(100, 50), gray(320, 180, 0)).within({}));
}

TEST(Comparison, OneChannelOffFails) {
    // By one more than what counts as close, everywhere: PSNR alone would be 20 log10(255 / 3) + 10 log10(3)
    // = 43.4.
    for (std::size_t channel = 0; channel < 3; ++channel) {
        Image off = gray(320, 180, 100);
        for (std::size_t i = channel; i < off.pixels.size(); i += 4) off.pixels[i] = 103;
        const auto result = compare(off, gray(320, 180, 100));
        EXPECT_FALSE(result.within({})) << result.toString();
        EXPECT_EQ(result.closeShare, 0.0);
        EXPECT_EQ(result.worst, 3);
        EXPECT_NEAR(result.psnr, 20.0 * std::log10(255.0 / 3.0) + 10.0 * std::log10(3.0), 1e-9);
    }
}

TEST(Comparison, ExchangedChannelsFail) {
    Image one = gray(320, 180, 50), other = gray(320, 180, 50);
    for (std::size_t i = 0; i < one.pixels.size(); i += 4) one.pixels[i] = other.pixels[i + 2] = 60;
    EXPECT_FALSE(compare(one, other).within({}));
}

TEST(Comparison, AlphaCounts) {
    Image clear = gray(4, 4, 7);
    clear.pixels[7] = 0;
    EXPECT_FALSE(compare(clear, gray(4, 4, 7)).within({}));
}

TEST(Comparison, AUpsideDownPictureFails) {
    EXPECT_FALSE(compare(withPoint(100, 179 - 50), withPoint(100, 50)).within({}));
}

TEST(Comparison, RoundingIsNoDifference) {
    // A picture off by one everywhere has 20 log10(255) = 48.1 dB.
    const auto result = compare(gray(320, 180, 101), gray(320, 180, 100));
    EXPECT_TRUE(result.within({})) << result.toString();
    EXPECT_NEAR(result.psnr, 20.0 * std::log10(255.0), 1e-9);
}

TEST(Comparison, APixelInDoubtMayBeAnyButCountsInTheMean) {
    std::vector<std::uint8_t> doubtful(320 * 180, 0);
    doubtful[50 * 320 + 100] = 1;
    const auto result = compare(gray(320, 180, 0), withPoint(100, 50), doubtful);
    EXPECT_EQ(result.worst, 0);
    EXPECT_FALSE(std::isinf(result.psnr));
    EXPECT_LT(result.closeShare, 1.0);
    EXPECT_TRUE(result.within({})) << result.toString();
}

TEST(Comparison, TheDifferenceShowsWhere) {
    const auto image = difference(withPoint(101, 50), withPoint(100, 50));
    EXPECT_EQ(image.pixels[4 * (50 * 320 + 100)], 255);
    EXPECT_EQ(image.pixels[4 * (50 * 320 + 99)], 0);
    EXPECT_EQ(std::count(image.pixels.begin(), image.pixels.end(), 255), 320 * 180 + 2 * 3);
}

}  // namespace
}  // namespace mote::test
