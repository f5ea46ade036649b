// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/stipple_quality/uneven_tone.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace mote::bench {
namespace {

using std::numbers::pi;

glm::dvec2 wrapped(glm::dvec2 at) {
    return {at.x - std::floor(at.x), at.y - std::floor(at.y)};
}

double discs(glm::dvec2 at) {
    const auto cell = wrapped(3.0 * at);
    return glm::distance(cell, glm::dvec2(0.5)) < 0.3 ? 0.9 : 0.15;
}

/// Where a point lies by the dissertation's rules (2.2.3.1).
glm::dvec2 asked(const storage::StippleHierarchy& h, std::size_t point,
                 const std::vector<std::uint8_t>& drawn, Rule rule) {
    const glm::dvec2 first(h.positions[point].x, h.positions[point].y);
    glm::dvec2 sum(0.0);
    glm::dvec2 last = first;
    int count = 0;
    for (auto m = h.movesBegin[point]; m < h.movesBegin[point + 1]; ++m) {
        if (drawn[h.moveNeighbour[m]] != 0) continue;
        last = {h.movePosition[m].x, h.movePosition[m].y};
        sum += last;
        ++count;
    }
    if (rule == Rule::last || count == 0) return last;
    return sum / static_cast<double>(count);
}

}  // namespace

std::vector<NamedTone> tones() {
    return {{"gradient", [](glm::dvec2 at) { return 0.03 + 0.9 * std::abs(2.0 * wrapped(at).x - 1.0); }},
            {"waves",
             [](glm::dvec2 at) {
                 return 0.5 + 0.45 * std::sin(2.0 * pi * 3.0 * at.x) * std::sin(2.0 * pi * 2.0 * at.y);
             }},
            {"discs", discs}};
}

std::vector<glm::dvec2> drawUneven(const storage::StippleHierarchy& h, const render::StippleReplay& replay,
                                   const Tone& tone, Rule rule) {
    std::vector<float> shares;
    for (const auto& at : h.positions) shares.push_back(static_cast<float>(tone({at.x, at.y})));
    const auto drawn = replay.select(shares);
    std::vector<glm::dvec2> dots;
    for (const auto& placed : replay.place(drawn)) {
        dots.push_back(rule == Rule::prefix ? glm::dvec2(placed.position.x, placed.position.y)
                                            : asked(h, placed.point, drawn, rule));
    }
    return dots;
}

double countError(const storage::StippleHierarchy& h, const std::vector<glm::dvec2>& dots, const Tone& tone) {
    constexpr int side = 1024;
    double wanted = 0.0;
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) wanted += tone({(x + 0.5) / side, (y + 0.5) / side});
    }
    wanted *= static_cast<double>(h.size()) / (side * side);
    return static_cast<double>(dots.size()) / wanted - 1.0;
}

double dotDiameter(std::size_t points) {
    return std::sqrt(2.0 / (std::sqrt(3.0) * static_cast<double>(points)));
}

double closeShare(const std::vector<glm::dvec2>& dots, const std::function<double(glm::dvec2)>& diameter) {
    const int side = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(dots.size()))));
    const auto boxOf = [&](double at) { return std::min(side - 1, static_cast<int>(at * side)); };
    std::vector<std::vector<glm::dvec2>> boxes(static_cast<std::size_t>(side * side));
    for (const auto& dot : dots) {
        const auto at = wrapped(dot);
        boxes[static_cast<std::size_t>(boxOf(at.y) * side + boxOf(at.x))].push_back(at);
    }
    const auto isClose = [&](glm::dvec2 at) {
        const double own = diameter(at);
        const int reach = static_cast<int>(std::ceil(0.75 * own * side));
        for (int y = -reach; y <= reach; ++y) {
            for (int x = -reach; x <= reach; ++x) {
                const int column = (boxOf(at.x) + x + 4 * side) % side;
                const int row = (boxOf(at.y) + y + 4 * side) % side;
                for (const auto& other : boxes[static_cast<std::size_t>(row * side + column)]) {
                    auto difference = other - at;
                    difference -= glm::dvec2(std::round(difference.x), std::round(difference.y));
                    const double distance = glm::length(difference);
                    if (distance > 0.0 && distance < 0.75 * std::min(own, diameter(other))) return true;
                }
            }
        }
        return false;
    };
    std::size_t close = 0;
    for (const auto& dot : dots) close += isClose(wrapped(dot)) ? 1 : 0;
    return static_cast<double>(close) / static_cast<double>(std::max<std::size_t>(1, dots.size()));
}

}  // namespace mote::bench
