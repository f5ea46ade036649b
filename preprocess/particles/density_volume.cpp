// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/density_volume.h"

#include <cmath>

#include "preprocess/particles/morton.h"

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

}  // namespace mote::prep
