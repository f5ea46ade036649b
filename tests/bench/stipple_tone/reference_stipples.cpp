// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/stipple_tone/reference_stipples.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "server/render/layers/stipple/dot_cells.h"

namespace mote::bench {
namespace {

std::vector<glm::vec2> randomDots(const render::PixelMap& wanted, std::uint64_t seed) {
    std::vector<double> upTo;
    double sum = 0.0;
    for (std::size_t y = 0; y < wanted.height(); ++y) {
        for (const float value : wanted.row(y)) upTo.push_back(sum += value);
    }
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::vector<glm::vec2> dots(static_cast<std::size_t>(std::llround(sum)));
    for (auto& dot : dots) {
        const auto pixel = static_cast<std::size_t>(
            std::upper_bound(upTo.begin(), upTo.end() - 1, unit(random) * sum) - upTo.begin());
        dot = {static_cast<double>(pixel % wanted.width()) + unit(random),
               static_cast<double>(pixel / wanted.width()) + unit(random)};
    }
    return dots;
}

}  // namespace

std::vector<glm::vec2> secord(const render::PixelMap& wanted, int steps, std::uint64_t seed) {
    auto dots = randomDots(wanted, seed);
    for (int step = 0; step < steps; ++step) {
        const auto cells = render::dotCells(wanted, dots);
        for (std::size_t i = 0; i < dots.size(); ++i) dots[i] = cells[i].centroid;
    }
    return dots;
}

std::vector<glm::vec2> lindeBuzoGray(const render::PixelMap& wanted, int steps, std::uint64_t seed) {
    auto dots = randomDots(wanted, seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<float> jitter(-0.01F, 0.01F);
    for (int step = 0; step < steps; ++step) {
        const double hysteresis = 0.6 + 0.01 * step;
        const auto cells = render::dotCells(wanted, dots);
        std::vector<glm::vec2> next;
        bool changed = false;
        for (const auto& cell : cells) {
            if (cell.mass < 1.0 - 0.5 * hysteresis) {
                changed = true;
            } else if (cell.mass <= 1.0 + 0.5 * hysteresis) {
                next.emplace_back(cell.centroid);
            } else {
                const double mean = 0.5 * (cell.xx + cell.yy);
                const double apart = std::hypot(0.5 * (cell.xx - cell.yy), cell.xy);
                const double angle = 0.5 * std::atan2(2.0 * cell.xy, cell.xx - cell.yy);
                const double length = 0.5 * std::sqrt(std::max(mean + apart, 0.01));
                const glm::dvec2 half(length * std::cos(angle), length * std::sin(angle));
                next.emplace_back(cell.centroid + half + glm::dvec2(jitter(random), jitter(random)));
                next.emplace_back(cell.centroid - half + glm::dvec2(jitter(random), jitter(random)));
                changed = true;
            }
        }
        dots = std::move(next);
        if (!changed) break;
    }
    return dots;
}

}  // namespace mote::bench
