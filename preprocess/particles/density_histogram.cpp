// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/density_histogram.h"

#include <algorithm>

#include "storage/manifest.h"

namespace mote::prep {

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
