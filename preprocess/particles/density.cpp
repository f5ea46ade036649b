// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/density.h"

#include <algorithm>
#include <cmath>

#include "preprocess/particles/cell_plan.h"
#include "storage/manifest.h"

namespace mote::prep {

void addCells(std::span<const CellSum> cells, unsigned cellLevel, unsigned level, std::vector<double>& sums) {
    for (const auto& one : cells) sums[one.cell >> (3 * (cellLevel - level))] += one.weight;
}

std::vector<float> densityVolume(const std::vector<double>& sums, unsigned level) {
    const std::size_t size = std::size_t{1} << level;
    std::vector<float> volume(sums.size());
    for (std::size_t cell = 0; cell < sums.size(); ++cell) {
        if (sums[cell] == 0.0) continue;
        const auto at = mortonCell(cell);
        volume[(at[2] * size + at[1]) * size + at[0]] =
            static_cast<float>(std::ldexp(sums[cell], static_cast<int>(3 * level)));
    }
    return volume;
}

Range densityRange(std::span<const float> density) {
    const auto first = std::upper_bound(density.begin(), density.end(), 0.0F);
    if (first == density.end()) return {};
    return {*first, density.back()};
}

void addToHistogram(std::span<const float> density, std::span<const std::uint32_t> particles,
                    const LogDensity& scale, std::vector<std::uint64_t>& bins) {
    constexpr std::size_t count = storage::densityHistogramBins;
    bins.resize(count);
    for (std::size_t i = 0; i < density.size(); ++i) {
        // A density of zero has no logarithm; it belongs to the thinnest.
        const double t = density[i] > 0.0F ? scale.ofLeaf(density[i]) : 0.0;
        bins[std::min(count - 1, static_cast<std::size_t>(t * count))] += particles[i];
    }
}

}  // namespace mote::prep
