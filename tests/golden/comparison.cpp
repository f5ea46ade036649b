// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/comparison.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "protocol/base/mote_check.h"

namespace mote::test {
namespace {

bool sound(const Image& image) {
    const std::size_t pixels = std::size_t{image.width} * image.height;
    return pixels > 0 && image.pixels.size() == 4 * pixels;
}

}  // namespace

bool Comparison::within(const Limits& limits) const {
    return sameShape && sameAlpha && psnr >= limits.psnr && closeShare >= limits.closeShare &&
           worst <= limits.worst;
}

std::string Comparison::toString() const {
    if (!sameShape) return "the pictures differ in size, or are empty";
    return fmt::format("PSNR {:.2f} dB, {:.3f}% of pixels within {}/255, worst {}/255 at column {}, row {}{}",
                       psnr, 100.0 * closeShare, close, worst, column, row,
                       sameAlpha ? "" : ", alpha differs");
}

Comparison compare(const Image& actual, const Image& expected, std::span<const std::uint8_t> doubtful) {
    Comparison result;
    if (actual.width != expected.width || actual.height != expected.height) return result;
    if (!sound(actual) || !sound(expected)) return result;
    const std::size_t pixels = std::size_t{actual.width} * actual.height;
    MOTE_CHECK(doubtful.empty() || doubtful.size() == pixels);
    result.sameShape = result.sameAlpha = true;
    result.worst = 0;
    double squares = 0.0;
    std::size_t closePixels = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        int most = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const int off = std::abs(actual.pixels[4 * i + c] - expected.pixels[4 * i + c]);
            squares += off * off;
            most = std::max(most, off);
        }
        if (actual.pixels[4 * i + 3] != expected.pixels[4 * i + 3]) result.sameAlpha = false;
        if (most <= Comparison::close) ++closePixels;
        if (most <= result.worst || (!doubtful.empty() && doubtful[i] != 0)) continue;
        result.worst = most;
        result.column = static_cast<std::uint32_t>(i % actual.width);
        result.row = static_cast<std::uint32_t>(i / actual.width);
    }
    const double mean = squares / (3.0 * static_cast<double>(pixels));
    result.psnr =
        mean > 0.0 ? 10.0 * std::log10(255.0 * 255.0 / mean) : std::numeric_limits<double>::infinity();
    result.closeShare = static_cast<double>(closePixels) / static_cast<double>(pixels);
    return result;
}

Image difference(const Image& one, const Image& other) {
    MOTE_CHECK(one.width == other.width && one.height == other.height && sound(one) && sound(other));
    Image result = one;
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
        const int off = std::min(16 * std::abs(one.pixels[i] - other.pixels[i]), 255);
        result.pixels[i] = static_cast<std::uint8_t>(i % 4 == 3 ? 255 : off);
    }
    return result;
}

void keep(const Image& image, const std::string& name) {
    const auto path = std::filesystem::path(MOTE_GOLDEN_FOLDER) / (name + ".png");
    const auto status = writePng(image, path);
    EXPECT_TRUE(status.ok()) << status.error().toString();
}

bool keepAll() {
    return std::getenv("MOTE_GOLDEN_KEEP") != nullptr;
}

}  // namespace mote::test
