// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/learn_picture.h"

#include <algorithm>

namespace mote::server {
namespace {

std::vector<const render::GridField*> hybridsOf(const render::Scene& scene) {
    std::vector<const render::GridField*> hybrids;
    for (const auto& step : scene.hybrids) hybrids.push_back(step.get());
    return hybrids;
}

}  // namespace

ViewLoad loadOf(const render::Scene& scene, const PictureHistory& history) {
    ViewLoad load{.pixels = static_cast<double>(scene.view.width) * scene.view.height};
    for (const auto& step : scene.steps) {
        if (step == nullptr) continue;
        const auto thresholds = step->preview(0).threshold;
        const double share = thresholds.empty() ? 0.0 : thresholds.back();
        load.previewShare = load.points == 0.0 ? share : std::min(load.previewShare, share);
        load.points += static_cast<double>(step->pointCount());
    }
    if (scene.steps == history.steps && hybridsOf(scene) == history.hybrids)
        load.points = std::max(history.exactPoints, 0.01 * load.points);
    return load;
}

void learn(PictureHistory& history, const render::Scene& scene, const render::Picture& picture,
           const render::Quality& quality, double share, double ms) {
    const auto points = static_cast<double>(picture.pointsDrawn);
    history.quality.learn(static_cast<double>(picture.width) * picture.height, points, quality, ms);
    history.steps = scene.steps;
    history.hybrids = hybridsOf(scene);
    history.exactPoints = points / share;
}

}  // namespace mote::server
