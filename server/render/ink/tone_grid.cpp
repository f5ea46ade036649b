// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/tone_grid.h"

#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

constexpr double blurReach = 3.0;     // deviations from which on nothing is blurred
constexpr double cellsOfBlur = 2.0;   // cells of a deviation, at least
constexpr double mostOfABlur = 64.0;  // deviation in cells that is blurred at once

std::vector<float> gaussian(double deviation) {
    const auto most = static_cast<int>(std::ceil(blurReach * std::min(deviation, mostOfABlur)));
    std::vector<float> weights;
    double sum = 0.0;
    for (int i = -most; i <= most; ++i) {
        weights.push_back(static_cast<float>(std::exp(-0.5 * i * i / (deviation * deviation))));
        sum += static_cast<double>(weights.back());
    }
    for (auto& weight : weights) weight = static_cast<float>(static_cast<double>(weight) / sum);
    return weights;
}

/// Blurs rows, and turns rows into columns.
ToneGrid blurredAcross(const ToneGrid& grid, const std::vector<float>& weights) {
    ToneGrid turned(grid.height, grid.width);
    const auto half = static_cast<std::int64_t>(weights.size() / 2);
    const auto last = static_cast<std::int64_t>(grid.width) - 1;
    forInTurns(std::uint32_t{0}, grid.height, [&](std::uint32_t row) {
        const float* const values = &grid.values[grid.index(0, row)];
        for (std::int64_t column = 0; column <= last; ++column) {
            float sum = 0.0F;
            for (std::int64_t i = -half; i <= half; ++i)
                sum += weights[static_cast<std::size_t>(i + half)] *
                       values[std::clamp(column + i, std::int64_t{0}, last)];
            turned.at(row, static_cast<std::uint32_t>(column)) = sum;
        }
    });
    return turned;
}

std::uint32_t cellSize(double reading) {
    return static_cast<std::uint32_t>(std::max(1.0, std::floor(reading / cellsOfBlur)));
}

}  // namespace

ToneCells::ToneCells(std::uint32_t width, std::uint32_t height, double reading)
    : pixels(cellSize(reading)),
      columns((width + pixels - 1) / pixels),
      rows((height + pixels - 1) / pixels),
      blur(reading / pixels) {}

ToneGrid meansOf(const Raster<float>& picture, const ToneCells& cells) {
    ToneGrid grid(cells.columns, cells.rows);
    forInTurns(std::uint32_t{0}, cells.rows, [&](std::uint32_t row) {
        const std::uint32_t top = row * cells.pixels, bottom = std::min(top + cells.pixels, picture.height);
        for (std::uint32_t column = 0; column < cells.columns; ++column) {
            const std::uint32_t left = column * cells.pixels,
                                right = std::min(left + cells.pixels, picture.width);
            double sum = 0.0;
            for (std::uint32_t y = top; y < bottom; ++y) {
                for (std::uint32_t x = left; x < right; ++x) sum += static_cast<double>(picture.at(x, y));
            }
            grid.at(column, row) = static_cast<float>(sum / ((right - left) * double(bottom - top)));
        }
    });
    return grid;
}

ToneGrid blurred(const ToneGrid& grid, double deviation) {
    const auto weights = gaussian(deviation);
    return blurredAcross(blurredAcross(grid, weights), weights);
}

float toneAt(const ToneGrid& grid, const ToneCells& cells, const glm::dvec2& place) {
    const double x = std::clamp(place.x / cells.pixels - 0.5, 0.0, grid.width - 1.0);
    const double y = std::clamp(place.y / cells.pixels - 0.5, 0.0, grid.height - 1.0);
    const auto column = static_cast<std::uint32_t>(x), row = static_cast<std::uint32_t>(y);
    const std::uint32_t right = std::min(column + 1, grid.width - 1),
                        below = std::min(row + 1, grid.height - 1);
    const auto u = static_cast<float>(x - column), v = static_cast<float>(y - row);
    const float top = (1.0F - u) * grid.at(column, row) + u * grid.at(right, row);
    const float bottom = (1.0F - u) * grid.at(column, below) + u * grid.at(right, below);
    return (1.0F - v) * top + v * bottom;
}

}  // namespace mote::render
