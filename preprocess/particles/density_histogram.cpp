// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/density_histogram.h"

#include <algorithm>

#include "storage/manifest.h"

namespace mote::prep {

Range densityRange(const storage::Leaves& leaves) {
    // Ascending: the least above zero, and the last.
    const auto first = std::upper_bound(leaves.density.begin(), leaves.density.end(), 0.0F);
    if (first == leaves.density.end()) return {};
    return {*first, leaves.density.back()};
}

std::vector<std::uint64_t> densityHistogram(const storage::Leaves& leaves, const LogDensity& scale) {
    constexpr std::size_t bins = storage::densityHistogramBins;
    std::vector<std::uint64_t> histogram(bins);
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        // A density of zero has no logarithm; it belongs to the thinnest.
        const double t = leaves.density[i] > 0.0F ? scale.ofLeaf(leaves.density[i]) : 0.0;
        histogram[std::min(bins - 1, static_cast<std::size_t>(t * bins))] += leaves.pointCount[i];
    }
    return histogram;
}

}  // namespace mote::prep
