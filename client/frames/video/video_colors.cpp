// SPDX-License-Identifier: GPL-3.0-or-later
//
// Products of 16 bits, sums of 32, so that any processor vectorises the loops; compiled with -O3. libswscale
// takes as long and has every hundredth luma not the nearest.
#include "client/frames/video/video_colors.h"

#include <vector>

#include "protocol/base/mote_check.h"

namespace mote::client {
namespace {

constexpr int bits = 15;  // of the weights

constexpr std::int16_t weight(double value) {
    return static_cast<std::int16_t>(value * (1 << bits) + (value < 0 ? -0.5 : 0.5));
}

/// Weights of R, G and B; the rounding of the others is green's, so that grey stays grey.
struct Weights {
    constexpr Weights(double red, double blue, double sum)
        : r(weight(red)),
          g(static_cast<std::int16_t>(weight(sum) - weight(red) - weight(blue))),
          b(weight(blue)) {}
    std::int16_t r, g, b;
};

constexpr double lumaRange = 219.0 / 255, chromaRange = 224.0 / 255;
constexpr double red = 0.2126, blue = 0.0722, cbScale = 1.8556, crScale = 1.5748;
constexpr Weights luma(red* lumaRange, blue* lumaRange, lumaRange);
constexpr Weights cb(-red / cbScale * chromaRange, 0.5 * chromaRange, 0);
constexpr Weights cr(0.5 * chromaRange, -blue / crScale * chromaRange, 0);

/// Of sums of 2^shift samples each.
template <int shift>
std::uint8_t weigh(const Weights& by, std::int16_t r, std::int16_t g, std::int16_t b, int offset) {
    constexpr int all = bits + shift;
    return static_cast<std::uint8_t>((by.r * r + by.g * g + by.b * b + (offset << all) + (1 << (all - 1))) >>
                                     all);
}

void lumaRow(const std::uint8_t* __restrict rgba, std::size_t width, std::uint8_t* __restrict y) {
    for (std::size_t i = 0; i < width; ++i) {
        y[i] = weigh<0>(luma, rgba[4 * i], rgba[4 * i + 1], rgba[4 * i + 2], 16);
    }
}

void chromaRow(const std::uint8_t* __restrict rgba, std::size_t width, std::uint8_t* __restrict u,
               std::uint8_t* __restrict v) {
    for (std::size_t i = 0; i < width; ++i) {
        const std::int16_t r = rgba[4 * i], g = rgba[4 * i + 1], b = rgba[4 * i + 2];
        u[i] = weigh<0>(cb, r, g, b, 128);
        v[i] = weigh<0>(cr, r, g, b, 128);
    }
}

/// Sums of two rows, a plane a channel, with the first column once more before them.
void sumRows(const std::uint8_t* __restrict upper, const std::uint8_t* __restrict lower, std::size_t width,
             std::int16_t* __restrict sums) {
    for (std::size_t c = 0; c < 3; ++c) {
        std::int16_t* __restrict plane = sums + c * (width + 1);
        plane[0] = static_cast<std::int16_t>(upper[c] + lower[c]);
        for (std::size_t i = 0; i < width; ++i) {
            plane[i + 1] = static_cast<std::int16_t>(upper[4 * i + c] + lower[4 * i + c]);
        }
    }
}

/// Weights 1, 2, 1 of the columns about every other one.
void halvedRow(const std::int16_t* __restrict sums, std::size_t width, std::uint8_t* __restrict u,
               std::uint8_t* __restrict v) {
    const auto around = [&](std::size_t c, std::size_t i) {
        const std::int16_t* at = sums + c * (width + 1) + 2 * i;
        return static_cast<std::int16_t>(at[0] + 2 * at[1] + at[2]);
    };
    for (std::size_t i = 0; i < width / 2; ++i) {
        const std::int16_t r = around(0, i), g = around(1, i), b = around(2, i);
        u[i] = weigh<3>(cb, r, g, b, 128);
        v[i] = weigh<3>(cr, r, g, b, 128);
    }
}

}  // namespace

void rgbaToVideo(std::uint32_t width, std::span<const std::uint8_t> rgba, VideoChroma chroma,
                 const VideoPlanes& planes) {
    MOTE_CHECK(width != 0 && rgba.size() % (std::size_t{4} * width) == 0);
    const std::size_t rows = rgba.size() / (std::size_t{4} * width);
    const auto pixels = [&](std::size_t y) { return rgba.data() + y * 4 * width; };
    for (std::size_t y = 0; y < rows; ++y) {
        lumaRow(pixels(y), width, planes.row(0, y));
        if (chroma == VideoChroma::full) chromaRow(pixels(y), width, planes.row(1, y), planes.row(2, y));
    }
    if (chroma == VideoChroma::full) return;
    MOTE_CHECK(width % 2 == 0 && rows % 2 == 0);
    std::vector<std::int16_t> sums(std::size_t{3} * (width + 1));
    for (std::size_t y = 0; y < rows; y += 2) {
        sumRows(pixels(y), pixels(y + 1), width, sums.data());
        halvedRow(sums.data(), width, planes.row(1, y / 2), planes.row(2, y / 2));
    }
}

}  // namespace mote::client
