// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view_parts.h"

#include <algorithm>
#include <utility>

namespace mote {
namespace {

/// It shows two steps, of which something is seen.
bool between(const Layer& layer) {
    return layer.towards && layer.opacity > 0.0 && layer.towards->step != layer.step &&
           layer.towards->share > 0.0 && layer.towards->share < 1.0;
}

}  // namespace

std::vector<ViewPart> viewParts(const View& view) {
    std::vector<double> ends{1.0};
    for (const auto& layer : view.layers) {
        if (between(layer)) ends.push_back(layer.towards->share);
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    std::vector<ViewPart> parts;
    double begin = 0.0;
    for (const double end : ends) {
        parts.push_back({begin + 0.5 * (end - begin), end - begin});
        begin = end;
    }
    if (parts.size() == 1) parts.front().place = nearestPlace;
    return parts;
}

View viewAt(View view, double place) {
    for (auto& layer : view.layers) {
        if (!layer.towards) continue;
        if (!between(layer)) {
            if (layer.towards->share >= 1.0) layer.step = layer.towards->step;
            layer.towards.reset();
        } else if (place < layer.towards->share) {
            // The same way, seen from its other end.
            std::swap(layer.step, layer.towards->step);
            layer.towards->share = 1.0 - layer.towards->share;
        }
    }
    return view;
}

}  // namespace mote
