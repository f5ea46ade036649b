// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <cmath>
#include <random>
#include <vector>

#include "protocol/wire/row_filter.h"
#include "protocol/wire/ycc.h"

namespace mote::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(RowFilter, BytesLieAsDocumented) {
    const Bytes rgba{10,  20, 30, 255, 13,  18,  30, 255,  //
                     200, 0,  1,  255, 100, 255, 3,  255};
    Bytes filtered(12);
    filterRows(proto::SRGB8, 2, rgba, filtered);
    EXPECT_EQ(filtered, (Bytes{10, 20, 30, 3, 254, 0, 200, 0, 1, 156, 255, 2}));
}

TEST(RowFilter, HalvesLieAsDocumented) {
    const Bytes rgba{0x01, 0x3c, 0x00, 0x40, 0xff, 0x00, 0x00, 0x3c,  //
                     0x00, 0x3c, 0x10, 0x40, 0x00, 0x02, 0x00, 0x3c};
    Bytes filtered(12);
    filterRows(proto::LINEAR_HALF, 2, rgba, filtered);
    // Differences: 3c01 4000 00ff, then ffff 0010 0101; low bytes first.
    EXPECT_EQ(filtered, (Bytes{0x01, 0x00, 0xff, 0xff, 0x10, 0x01, 0x3c, 0x40, 0x00, 0xff, 0x00, 0x01}));
}

TEST(RowFilter, EveryPictureComesBack) {
    std::mt19937 random(11);
    for (const auto format : {proto::SRGB8, proto::LINEAR_HALF}) {
        const std::size_t size = pixelSize(format);
        for (const std::uint32_t width : {1u, 2u, 15u, 16u, 17u, 101u}) {
            Bytes rgba(size * width * 5);
            for (auto& byte : rgba) byte = static_cast<std::uint8_t>(random());
            for (std::size_t pixel = 0; pixel < rgba.size(); pixel += size) {
                if (format == proto::SRGB8) {
                    rgba[pixel + 3] = 255;
                } else {
                    rgba[pixel + 6] = 0x00;
                    rgba[pixel + 7] = 0x3c;
                }
            }
            Bytes filtered(filteredPixelSize(format) * width * 5);
            Bytes again(rgba.size());
            filterRows(format, width, rgba, filtered);
            unfilterRows(format, width, filtered, again);
            EXPECT_EQ(again, rgba) << width;
        }
    }
}

TEST(RowFilter, AnUnknownFormatHasNoSize) {
    const auto unknown = static_cast<proto::PixelFormat>(99);
    EXPECT_EQ(pixelSize(unknown), 0u);
    EXPECT_EQ(filteredPixelSize(unknown), 0u);
    EXPECT_EQ(pixelSize(proto::PIXEL_FORMAT_UNSPECIFIED), 0u);
}

struct Planes {
    Planes(std::uint32_t width, std::uint32_t height)
        : half((width + 1) / 2),
          luma(std::size_t{width} * height),
          cb(static_cast<std::size_t>(half) * ((height + 1) / 2)),
          cr(cb.size()),
          stride(width) {}

    YccPicture<std::uint8_t> write() { return {{luma.data(), cb.data(), cr.data()}, {stride, half, half}}; }
    YccPicture<const std::uint8_t> read() const {
        return {{luma.data(), cb.data(), cr.data()}, {stride, half, half}};
    }

    std::ptrdiff_t half;
    Bytes luma, cb, cr;
    std::ptrdiff_t stride;
};

/// Blocks of two by two pixels of one colour.
Bytes blocks(std::uint32_t width, std::uint32_t height, unsigned seed) {
    Bytes rgba(std::size_t{4} * width * height);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            std::minstd_rand random(seed + 1000 * (y / 2) + x / 2);
            random.discard(5);
            for (int c = 0; c < 3; ++c) {
                rgba[4 * (std::size_t{y} * width + x) + static_cast<std::size_t>(c)] =
                    static_cast<std::uint8_t>(random() >> 10);
            }
            rgba[4 * (std::size_t{y} * width + x) + 3] = 255;
        }
    }
    return rgba;
}

TEST(Ycc, IsTheStandardsMatrixInFullRange) {
    const Bytes rgba = blocks(64, 64, 3);
    Planes planes(64, 64);
    rgbaToYcc(64, rgba, planes.write());
    for (std::size_t y = 0; y < 64; ++y) {
        for (std::size_t x = 0; x < 64; ++x) {
            const double r = rgba[4 * (64 * y + x)], g = rgba[4 * (64 * y + x) + 1],
                         b = rgba[4 * (64 * y + x) + 2];
            const double luma = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            // Half a step of rounding, and weights that are off by up to 1/512 of 255 each.
            ASSERT_NEAR(planes.luma[64 * y + x], luma, 1.5);
            ASSERT_NEAR(planes.cb[32 * (y / 2) + x / 2], std::min(255.0, (b - luma) / 1.8556 + 128), 1.5);
            ASSERT_NEAR(planes.cr[32 * (y / 2) + x / 2], std::min(255.0, (r - luma) / 1.5748 + 128), 1.5);
        }
    }
}

TEST(Ycc, ColoursComeBack) {
    for (const auto& [width, height] : {std::pair{64u, 64u}, {1u, 1u}, {3u, 5u}, {515u, 7u}, {258u, 3u}}) {
        const Bytes rgba = blocks(width, height, width);
        Planes planes(width, height);
        Bytes again(rgba.size());
        rgbaToYcc(width, rgba, planes.write());
        yccToRgba(width, planes.read(), again);
        for (std::size_t i = 0; i < rgba.size(); ++i) {
            // A step of chroma is up to 1.86 of blue; half of one is lost to rounding, and half of one of
            // luma.
            ASSERT_NEAR(again[i], rgba[i], 3) << width << " x " << height << " at " << i;
        }
    }
}

}  // namespace
}  // namespace mote::wire
