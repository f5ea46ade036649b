// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/stipple_quality/plane_levels.h"

#include <algorithm>
#include <cmath>

namespace mote::bench {

std::vector<double> levels(std::uint32_t points) {
    std::vector<double> shares;
    for (int i = 19; i >= 1; --i) {
        if (0.05 * i * points >= 250.0) shares.push_back(0.05 * i);
    }
    return shares;
}

std::vector<glm::dvec2> drawnAt(const render::StippleReplay& replay, double share) {
    const std::vector<float> shares(replay.size(), static_cast<float>(share));
    std::vector<glm::dvec2> dots;
    for (const auto& placed : replay.place(replay.select(shares))) {
        dots.emplace_back(placed.position.x, placed.position.y);
    }
    return dots;
}

test::PlaneMeasures worst(std::span<const test::PlaneMeasures> measures) {
    auto result = measures.front();
    for (const auto& m : measures) {
        result.rho = std::min(result.rho, m.rho);
        result.nearest = std::min(result.nearest, m.nearest);
        result.energy = std::max(result.energy, m.energy);
        result.areaCv = std::max(result.areaCv, m.areaCv);
        result.lowEnergy = std::max(result.lowEnergy, m.lowEnergy);
    }
    return result;
}

bool meetsBars(const test::PlaneMeasures& m) {
    return m.rho >= 0.65 && m.nearest >= 0.86 && m.energy <= 1.05 && m.areaCv <= 0.085 &&
           m.lowEnergy <= 0.013;
}

double longestMove(const storage::StippleHierarchy& h, std::uint32_t but) {
    double longest = 0.0;
    for (std::size_t point = 0; point < h.size(); ++point) {
        auto last = h.positions[point];
        for (auto m = h.movesBegin[point]; m < h.movesBegin[point + 1]; ++m) {
            const auto left = static_cast<double>(h.size() - h.removal[h.moveNeighbour[m]] - 1);
            const auto step = h.movePosition[m] - last;
            last = h.movePosition[m];
            if (left < but) continue;
            longest = std::max(longest, std::hypot(step.x, step.y) * std::sqrt(left));
        }
    }
    return longest;
}

}  // namespace mote::bench
