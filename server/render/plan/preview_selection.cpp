// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/preview_selection.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace mote::render {
namespace {

/// The curve's fraction by density.
std::vector<double> fractions(const storage::ParticleStep& step, const storage::Preview& preview,
                              const Curve& pointFraction) {
    std::vector<double> result(PreviewSelection::densities);
    const double ratio = preview.scale.max / preview.scale.min;
    for (std::size_t i = 0; i < result.size(); ++i) {
        const double place = (static_cast<double>(i) + 0.5) / PreviewSelection::densities;
        const double density = ratio > 1.0 ? preview.scale.min * std::pow(ratio, place) : preview.scale.min;
        result[i] = pointFraction(step.logDensity().ofLeaf(density));
    }
    return result;
}

}  // namespace

std::optional<PreviewSelection> selectPreview(const storage::ParticleStep& step, const Curve& pointFraction,
                                              double share) {
    const storage::Preview preview = step.preview(0);
    if (preview.threshold.empty()) return std::nullopt;
    const auto fraction = fractions(step, preview, pointFraction);
    PreviewSelection selection;
    for (std::size_t i = 0; i < fraction.size(); ++i) {
        selection.limit[i] = static_cast<float>(share * fraction[i]);
    }
    const float most = *std::max_element(selection.limit.begin(), selection.limit.end());
    const auto& threshold = preview.threshold;
    const auto end = std::upper_bound(threshold.begin(), threshold.end(), most);
    if (end == threshold.end()) return std::nullopt;
    selection.points = static_cast<std::uint64_t>(end - threshold.begin()) * storage::Preview::blockPoints;
    return selection;
}

double previewShare(const storage::ParticleStep& step, const Curve& pointFraction, double share,
                    std::uint64_t points) {
    const storage::Preview preview = step.preview(0);
    const auto& threshold = preview.threshold;
    if (threshold.empty()) return 0.0;
    const auto fraction = fractions(step, preview, pointFraction);
    const double most = *std::max_element(fraction.begin(), fraction.end());
    if (most <= 0.0) return share;
    // A block is needed from its first point's threshold on: a little below that of the block after them.
    const auto blocks = std::min<std::uint64_t>(points / storage::Preview::blockPoints, threshold.size() - 1);
    return std::min(share, (1.0 - 1e-6) * threshold[blocks] / most);
}

}  // namespace mote::render
