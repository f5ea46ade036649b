// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/ycc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace mote::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

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
