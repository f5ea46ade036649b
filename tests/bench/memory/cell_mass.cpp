// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/memory/cell_mass.h"

#include <cmath>

namespace mote::bench {

CellMass::CellMass(unsigned deepestLevel) : deepestLevel_(deepestLevel) {
    const std::uint32_t cells = 1U << deepestLevel;
    for (auto& part : parts_) {
        const auto below = [&](double place) {
            return 0.5 * std::erfc((0.5 - place) / (part.width * std::sqrt(2.0)));
        };
        for (std::uint32_t i = 0; i <= cells; ++i) {
            part.below.push_back((below(static_cast<double>(i) / cells) - below(0.0)) /
                                 (below(1.0) - below(0.0)));
        }
    }
}

double CellMass::along(const Part& part, unsigned level, std::uint32_t at) const {
    const std::uint32_t edge = 1U << (deepestLevel_ - level);
    return part.below[(at + 1) * edge] - part.below[at * edge];
}

double CellMass::operator()(unsigned level, const std::array<std::uint32_t, 3>& at) const {
    double sum = 0.0;
    for (const auto& part : parts_) {
        sum += part.share * along(part, level, at[0]) * along(part, level, at[1]) * along(part, level, at[2]);
    }
    return sum;
}

}  // namespace mote::bench
