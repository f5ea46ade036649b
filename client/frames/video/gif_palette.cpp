// SPDX-License-Identifier: GPL-3.0-or-later
//
// A colour becomes a mix of two of the palette's: the one nearest to it, and the one that together with it
// comes nearest. Where a cell of 8 x 8 pixels has how much of the second one is Bayer's ordering.
#include "client/frames/video/gif_palette.h"

#include <algorithm>

#include "protocol/scene/mote_check.h"

namespace mote::client {
namespace {

constexpr std::uint32_t known = 1U << 24;
constexpr double levels = 64;        // of the pattern
constexpr double grainWeight = 0.1;  // how much a mix of colours far apart counts against it

/// 0 to 63, each once in 8 x 8 pixels.
constexpr std::uint32_t bayer(std::uint32_t x, std::uint32_t y) {
    std::uint32_t value = 0;
    for (std::uint32_t bit = 0; bit < 3; ++bit) {
        const std::uint32_t a = x >> bit & 1, b = y >> bit & 1;
        value = value << 2 | (a ^ b) << 1 | b;
    }
    return value;
}

constexpr auto pattern = [] {
    std::array<std::array<std::uint8_t, 8>, 8> rows{};
    for (std::uint32_t y = 0; y < 8; ++y) {
        for (std::uint32_t x = 0; x < 8; ++x) rows[y][x] = static_cast<std::uint8_t>(bayer(x, y));
    }
    return rows;
}();

SeenColor minus(const SeenColor& a, const SeenColor& b) {
    return {a.luma - b.luma, a.cb - b.cb, a.cr - b.cr};
}

double dot(const SeenColor& a, const SeenColor& b) {
    return a.luma * b.luma + a.cb * b.cb + a.cr * b.cr;
}

}  // namespace

SeenColor seenColor(double r, double g, double b) {
    constexpr double chroma = 0.7071067811865476;  // half the weight of a square
    const double luma = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    return {luma, chroma * (b - luma) / 1.8556, chroma * (r - luma) / 1.5748};
}

double squareDistance(const SeenColor& a, const SeenColor& b) {
    const auto d = minus(a, b);
    return dot(d, d);
}

GifDither::GifDither(const GifPalette& palette) : mixes_(std::size_t{1} << 24) {
    MOTE_CHECK(!palette.colors.empty() && palette.colors.size() <= GifPalette::mostColors);
    for (const auto& [r, g, b] : palette.colors) colors_.push_back(seenColor(r, g, b));
}

/// The nearest colour's index, the other's, and how many of 64 pixels are of the other.
std::uint32_t GifDither::mixOf(std::uint32_t rgb) {
    const auto wanted = seenColor(rgb & 255, rgb >> 8 & 255, rgb >> 16 & 255);
    const auto nearest = std::min_element(colors_.begin(), colors_.end(), [&](const auto& a, const auto& b) {
        return squareDistance(a, wanted) < squareDistance(b, wanted);
    });
    const auto off = minus(wanted, *nearest);
    std::uint32_t other = 0, share = 0;
    double least = dot(off, off);
    for (std::size_t i = 0; i < colors_.size() && least > 0; ++i) {
        const auto way = minus(colors_[i], *nearest);
        const double length = dot(way, way);
        if (length <= 0) continue;
        const double at = std::clamp(dot(off, way) / length, 0.0, 0.5);
        const auto miss = SeenColor{off.luma - at * way.luma, off.cb - at * way.cb, off.cr - at * way.cr};
        const double cost = dot(miss, miss) + grainWeight * at * (1 - at) * length;
        if (cost >= least) continue;
        least = cost;
        other = static_cast<std::uint32_t>(i);
        share = static_cast<std::uint32_t>(at * levels + 0.5);
    }
    return known | share << 16 | other << 8 | static_cast<std::uint32_t>(nearest - colors_.begin());
}

void GifDither::row(std::uint32_t y, std::span<const std::uint8_t> rgba, std::uint8_t* indices) {
    const auto& thresholds = pattern[y % 8];
    for (std::size_t i = 0; 4 * i < rgba.size(); ++i) {
        const std::uint32_t rgb =
            rgba[4 * i] | std::uint32_t{rgba[4 * i + 1]} << 8 | std::uint32_t{rgba[4 * i + 2]} << 16;
        auto& mix = mixes_[rgb];
        if (mix == 0) mix = mixOf(rgb);
        const bool second = thresholds[i % 8] < (mix >> 16 & 255);
        indices[i] = static_cast<std::uint8_t>(second ? mix >> 8 : mix);
    }
}

}  // namespace mote::client
