// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/stipple_quality/quality_pictures.h"

#include <algorithm>
#include <cmath>

#include "tests/support/plane_measures.h"

namespace mote::bench {
namespace {

test::Image blank(std::uint32_t size, std::uint8_t grey) {
    test::Image image{size, size, std::vector<std::uint8_t>(std::size_t{4} * size * size, grey)};
    for (std::size_t i = 3; i < image.pixels.size(); i += 4) image.pixels[i] = 255;
    return image;
}

void setGrey(test::Image& image, std::size_t pixel, double grey) {
    const auto value = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
    std::fill_n(&image.pixels[4 * pixel], 3, value);
}

}  // namespace

test::Image dotPicture(const std::vector<glm::dvec2>& dots, std::uint32_t size, double diameter) {
    auto image = blank(size, 255);
    const double radius = 0.5 * diameter;
    const int side = static_cast<int>(size);
    for (const auto& dot : dots) {
        const double cx = (dot.x - std::floor(dot.x)) * size;
        const double cy = (1.0 - dot.y + std::floor(dot.y)) * size;
        const int reach = static_cast<int>(radius) + 2;
        for (int y = static_cast<int>(cy) - reach; y <= static_cast<int>(cy) + reach; ++y) {
            for (int x = static_cast<int>(cx) - reach; x <= static_cast<int>(cx) + reach; ++x) {
                const double distance = std::hypot(x + 0.5 - cx, y + 0.5 - cy);
                const double coverage = std::clamp(radius + 0.5 - distance, 0.0, 1.0);
                const auto pixel = static_cast<std::size_t>((y + side) % side) * size +
                                   static_cast<std::size_t>((x + side) % side);
                setGrey(image, pixel, image.pixels[4 * pixel] * (1.0 - coverage));
            }
        }
    }
    return image;
}

test::Image spectrumPicture(const std::vector<glm::dvec2>& dots) {
    const int reach = static_cast<int>(3.0 * std::sqrt(static_cast<double>(dots.size())));
    const auto power = test::spectrum(dots, reach);
    auto image = blank(static_cast<std::uint32_t>(2 * reach + 1), 0);
    const auto middle = power.size() / 2;
    for (std::size_t i = 0; i < power.size(); ++i) {
        if (i != middle) setGrey(image, i, 128.0 * std::sqrt(power[i]));
    }
    return image;
}

}  // namespace mote::bench
