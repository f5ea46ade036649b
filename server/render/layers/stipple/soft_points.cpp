// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/soft_points.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace mote::render {
namespace {

constexpr float fade = 1.0F / SoftPoints::pictures;
constexpr float glide = 0.5F;  // of the way that is left, in each picture

/// A point that is shown and wanted, one picture later.
ShownPoint nextOf(const ShownPoint& shown, const ShownPoint& wanted, float close) {
    ShownPoint next = wanted;
    next.presence = std::min(shown.presence + fade, 1.0F);
    const glm::vec3 way = wanted.position - shown.position;
    if (glm::length(way) > close) next.position = shown.position + glide * way;
    return next;
}

}  // namespace

const std::vector<ShownPoint>& SoftPoints::step(const StippleSurface& surface, const SurfaceDots& layer,
                                                std::vector<ShownPoint> wanted) {
    if (shown_.empty()) return settle(std::move(wanted));
    std::vector<ShownPoint> next;
    bool settled = true;
    auto old = shown_.begin();
    const auto vanish = [&](const ShownPoint& shown) {
        // A point that the surface hides is gone at once: nothing shines through.
        if (shown.presence <= fade || !layer.visible(shown.point, shown.position)) return;
        next.push_back({shown.point, shown.position, shown.presence - fade});
        settled = false;
    };
    for (const auto& point : wanted) {
        for (; old != shown_.end() && old->point < point.point; ++old) vanish(*old);
        const bool known = old != shown_.end() && old->point == point.point;
        next.push_back(known ? nextOf(*old++, point, surface.tolerance())
                             : ShownPoint{point.point, point.position, fade});
        settled = settled && next.back().presence == 1.0F && next.back().position == point.position;
    }
    for (; old != shown_.end(); ++old) vanish(*old);
    shown_ = std::move(next);
    settled_ = settled;
    return shown_;
}

const std::vector<ShownPoint>& SoftPoints::settle(std::vector<ShownPoint> wanted) {
    shown_ = std::move(wanted);
    settled_ = true;
    return shown_;
}

}  // namespace mote::render
