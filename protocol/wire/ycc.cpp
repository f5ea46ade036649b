// SPDX-License-Identifier: GPL-3.0-or-later
//
// In 16 bits, so that any processor does eight pixels at a time; the weights are rounded to 1/256 there and
// to 1/64 back, which adds less to the error than that the samples are bytes. Compiled with -O3: the compiler
// vectorises the loops.
#include "protocol/wire/ycc.h"

#include <algorithm>
#include <cstring>

#include "protocol/base/mote_check.h"

namespace mote::wire {
namespace {

constexpr std::uint32_t redAndBlue = 0x00ff00ff;  // of a pixel as a little-endian word

std::uint32_t load(const std::uint8_t* pixel) {
    std::uint32_t word = 0;
    std::memcpy(&word, pixel, sizeof word);
    return word;
}

std::uint8_t high(int sum) {
    return static_cast<std::uint8_t>(static_cast<std::uint16_t>(sum) >> 8);
}

// Each row of weights sums to 256 (luma) or 0 (chroma): grey stays grey, and no sum leaves 16 bits.

void lumaRow(const std::uint8_t* __restrict rgba, std::size_t width, std::uint8_t* __restrict luma) {
    for (std::size_t i = 0; i < width; ++i) {
        const auto r = static_cast<std::uint16_t>(rgba[4 * i]);
        const auto g = static_cast<std::uint16_t>(rgba[4 * i + 1]);
        const auto b = static_cast<std::uint16_t>(rgba[4 * i + 2]);
        luma[i] = high(54 * r + 183 * g + 19 * b + 128);
    }
}

struct Chroma {
    std::uint8_t cb, cr;
};

/// The chroma of the mean of four pixels.
Chroma chromaOf(std::uint32_t p, std::uint32_t q, std::uint32_t s, std::uint32_t t) {
    const std::uint32_t rb = (p & redAndBlue) + (q & redAndBlue) + (s & redAndBlue) + (t & redAndBlue);
    const std::uint32_t green = (p >> 8 & 0xff) + (q >> 8 & 0xff) + (s >> 8 & 0xff) + (t >> 8 & 0xff);
    const auto r = static_cast<std::uint16_t>(((rb & 0xffff) + 2) >> 2);
    const auto g = static_cast<std::uint16_t>((green + 2) >> 2);
    const auto b = static_cast<std::uint16_t>(((rb >> 16) + 2) >> 2);
    return {high(128 * b - 29 * r - 99 * g + 32768 + 127), high(128 * r - 116 * g - 12 * b + 32768 + 127)};
}

void chromaRow(const std::uint8_t* __restrict upper, const std::uint8_t* __restrict lower, std::size_t width,
               std::uint8_t* __restrict cb, std::uint8_t* __restrict cr) {
    for (std::size_t i = 0; i < width / 2; ++i) {
        const auto chroma = chromaOf(load(upper + 8 * i), load(upper + 8 * i + 4), load(lower + 8 * i),
                                     load(lower + 8 * i + 4));
        cb[i] = chroma.cb;
        cr[i] = chroma.cr;
    }
    if (width % 2 == 0) return;
    const std::uint32_t p = load(upper + 4 * (width - 1)), s = load(lower + 4 * (width - 1));
    const auto chroma = chromaOf(p, p, s, s);
    cb[width / 2] = chroma.cb;
    cr[width / 2] = chroma.cr;
}

std::uint16_t toByte(int sum) {
    const auto value = static_cast<std::int16_t>(static_cast<std::int16_t>(sum) >> 6);
    return static_cast<std::uint16_t>(std::clamp<std::int16_t>(value, std::int16_t{0}, std::int16_t{255}));
}

/// A pixel for each luma sample; chroma is that of each pixel, less 128.
void pixels(const std::uint8_t* __restrict luma, const std::int16_t* __restrict u,
            const std::int16_t* __restrict v, std::size_t count, std::uint8_t* __restrict rgba) {
    for (std::size_t i = 0; i < count; ++i) {
        const auto y = static_cast<std::int16_t>(64 * luma[i] + 32);
        const auto redGreen =
            static_cast<std::uint16_t>(toByte(y + 101 * v[i]) | toByte(y - 12 * u[i] - 30 * v[i]) << 8);
        const auto blueAlpha = static_cast<std::uint16_t>(toByte(y + 119 * u[i]) | 0xff00);
        const std::uint32_t pixel = redGreen | std::uint32_t{blueAlpha} << 16;
        std::memcpy(rgba + 4 * i, &pixel, sizeof pixel);
    }
}

constexpr std::size_t block = 256;  // pixels whose chroma is spread at a time

void spread(const std::uint8_t* __restrict chroma, std::size_t count, std::int16_t* __restrict wide) {
    for (std::size_t i = 0; i < count; ++i) {
        const auto value = static_cast<std::int16_t>(chroma[i] - 128);
        wide[2 * i] = value;
        wide[2 * i + 1] = value;
    }
}

void rgbaRow(const std::uint8_t* luma, const std::uint8_t* cb, const std::uint8_t* cr, std::size_t width,
             std::uint8_t* rgba) {
    std::array<std::int16_t, block> u, v;
    for (std::size_t begin = 0; begin < width; begin += block) {
        const std::size_t count = std::min(block, width - begin);
        spread(cb + begin / 2, (count + 1) / 2, u.data());
        spread(cr + begin / 2, (count + 1) / 2, v.data());
        pixels(luma + begin, u.data(), v.data(), count, rgba + 4 * begin);
    }
}

std::size_t rowCount(std::uint32_t width, std::size_t bytes) {
    MOTE_CHECK(width != 0);
    const std::size_t rows = bytes / (std::size_t{4} * width);
    MOTE_CHECK(bytes == rows * 4 * width);
    return rows;
}

}  // namespace

void rgbaToYcc(std::uint32_t width, std::span<const std::uint8_t> rgba, const YccPicture<std::uint8_t>& ycc) {
    const std::size_t rows = rowCount(width, rgba.size());
    const auto pixels = [&](std::size_t row) { return rgba.data() + row * 4 * width; };
    for (std::size_t row = 0; row < rows; ++row) lumaRow(pixels(row), width, ycc.row(0, row));
    for (std::size_t row = 0; row < rows; row += 2) {
        chromaRow(pixels(row), pixels(std::min(row + 1, rows - 1)), width, ycc.row(1, row / 2),
                  ycc.row(2, row / 2));
    }
}

void yccToRgba(std::uint32_t width, const YccPicture<const std::uint8_t>& ycc, std::span<std::uint8_t> rgba) {
    const std::size_t rows = rowCount(width, rgba.size());
    for (std::size_t row = 0; row < rows; ++row) {
        rgbaRow(ycc.row(0, row), ycc.row(1, row / 2), ycc.row(2, row / 2), width,
                rgba.data() + row * 4 * width);
    }
}

}  // namespace mote::wire
