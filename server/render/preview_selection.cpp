// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/preview_selection.h"

#include <algorithm>
#include <cmath>

namespace mote::render {
std::optional<PreviewSelection> selectPreview(const storage::ParticleStep& step, const Curve& pointFraction,
                                              double share) {
    const storage::Preview preview = step.preview(0);
    if (preview.threshold.empty()) return std::nullopt;
    PreviewSelection selection;
    const double ratio = preview.scale.max / preview.scale.min;
    double most = 0.0;
    for (std::size_t i = 0; i < PreviewSelection::densities; ++i) {
        const double place = (static_cast<double>(i) + 0.5) / PreviewSelection::densities;
        const double density = ratio > 1.0 ? preview.scale.min * std::pow(ratio, place) : preview.scale.min;
        const double fraction = share * pointFraction(step.logDensity().ofLeaf(density));
        selection.limit[i] = static_cast<float>(fraction);
        most = std::max(most, fraction);
    }
    const auto& threshold = preview.threshold;
    const auto end = std::upper_bound(threshold.begin(), threshold.end(), static_cast<float>(most));
    if (end == threshold.end()) return std::nullopt;
    selection.points = static_cast<std::uint64_t>(end - threshold.begin()) * storage::Preview::blockPoints;
    return selection;
}

}  // namespace mote::render
