// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/stipple_tone/tone_measure.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "protocol/scene/srgb.h"
#include "server/render/layers/stipple/tone.h"
#include "server/render/plan/dot.h"

namespace mote::bench {
namespace {

/// Rows along x; called twice, each time turned.
Grid blurredAndTurned(const Grid& grid, const std::vector<double>& kernel) {
    const int reach = static_cast<int>(kernel.size()) - 1;
    const int width = static_cast<int>(grid.width);
    Grid turned{grid.height, grid.width, std::vector<float>(grid.values.size())};
    for (int y = 0; y < static_cast<int>(grid.height); ++y) {
        const float* row = &grid.values[static_cast<std::size_t>(y) * grid.width];
        for (int x = 0; x < width; ++x) {
            double sum = 0.0, weight = 0.0;
            for (int i = std::max(x - reach, 0); i <= std::min(x + reach, width - 1); ++i) {
                const double w = kernel[static_cast<std::size_t>(std::abs(i - x))];
                sum += w * row[i];
                weight += w;
            }
            turned.values[static_cast<std::size_t>(x) * grid.height + static_cast<std::size_t>(y)] =
                static_cast<float>(sum / weight);
        }
    }
    return turned;
}

}  // namespace

Grid drawDots(std::uint32_t width, std::uint32_t height, std::span<const glm::vec2> dots, double diameter) {
    Grid grid{width, height, std::vector<float>(std::size_t{width} * height)};
    const render::DotFootprint footprint(static_cast<float>(0.5 * diameter));
    for (const auto& dot : dots) {
        const int x0 = std::max(static_cast<int>(std::floor(dot.x - footprint.reach)), 0);
        const int x1 =
            std::min(static_cast<int>(std::ceil(dot.x + footprint.reach)), static_cast<int>(width));
        const int y0 = std::max(static_cast<int>(std::floor(dot.y - footprint.reach)), 0);
        const int y1 =
            std::min(static_cast<int>(std::ceil(dot.y + footprint.reach)), static_cast<int>(height));
        for (int y = y0; y < y1; ++y) {
            for (int x = x0; x < x1; ++x) {
                const float dx = static_cast<float>(x) + 0.5F - dot.x;
                const float dy = static_cast<float>(y) + 0.5F - dot.y;
                auto& ink = grid.values[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)];
                ink += (1.0F - ink) * footprint.coverage(std::hypot(dx, dy));
            }
        }
    }
    return grid;
}

Grid wantedInk(const render::PixelMap& density, double diameter) {
    Grid grid{density.width(), density.height(), {}};
    const double area = std::numbers::pi / 4.0 * diameter * diameter;
    for (std::size_t y = 0; y < density.height(); ++y) {
        for (const float value : density.row(y)) {
            grid.values.push_back(static_cast<float>(render::inkOfCover(value * area)));
        }
    }
    return grid;
}

Grid blurred(const Grid& grid, double sigma) {
    std::vector<double> kernel;
    for (int i = 0; i <= static_cast<int>(std::ceil(4.0 * sigma)); ++i) {
        kernel.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    }
    return blurredAndTurned(blurredAndTurned(grid, kernel), kernel);
}

bool writeInk(const Grid& ink, const std::string& path) {
    std::vector<std::uint8_t> bytes;
    for (const float value : ink.values) {
        bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0 * linearToSrgb(1.0 - value))));
    }
    const auto output = OIIO::ImageOutput::create(path);
    const OIIO::ImageSpec spec(static_cast<int>(ink.width), static_cast<int>(ink.height), 1,
                               OIIO::TypeDesc::UINT8);
    return output && output->open(path, spec) && output->write_image(OIIO::TypeDesc::UINT8, bytes.data()) &&
           output->close();
}

double psnr(const Grid& a, const Grid& b, double sigma) {
    const auto left = blurred(a, sigma);
    const auto right = blurred(b, sigma);
    double sum = 0.0;
    for (std::size_t i = 0; i < left.values.size(); ++i) {
        const double apart = left.values[i] - right.values[i];
        sum += apart * apart;
    }
    return 10.0 * std::log10(static_cast<double>(left.values.size()) / sum);
}

}  // namespace mote::bench
