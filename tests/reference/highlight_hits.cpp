// SPDX-License-Identifier: GPL-3.0-or-later
//
// docs/PICTURE.md, "Highlights".
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "server/render/layers/particles/lower_particles.h"
#include "tests/reference/leaf_points.h"
#include "tests/reference/point_hits.h"

namespace mote::reference {
namespace {

struct Depths {
    double nearest, farthest;
};

Depths boxDepths(const glm::dmat4& layerToEye) {
    Depths depths{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (unsigned i = 0; i < 8; ++i) {
        const glm::dvec4 corner(i & 1U ? 1.0 : -1.0, i & 2U ? 1.0 : -1.0, i & 4U ? 1.0 : -1.0, 1.0);
        const double depth = -(layerToEye * corner).z;
        depths = {std::min(depths.nearest, depth), std::max(depths.farthest, depth)};
    }
    return depths;
}

/// From two standard deviations before the mean to one behind it, each no less than a 64th of the box.
Depths shaded(const std::vector<glm::dvec3>& inEye, const Depths& box) {
    double mean = 0.0, variance = 0.0;
    for (const auto& place : inEye) mean -= place.z / static_cast<double>(inEye.size());
    for (const auto& place : inEye)
        variance += (-place.z - mean) * (-place.z - mean) / static_cast<double>(inEye.size());
    const double deviation = std::max(std::sqrt(variance), (box.farthest - box.nearest) / 64.0);
    return {mean - 2.0 * deviation, mean + deviation};
}

}  // namespace

/// All of them stand a little before the layer's box, or where anything begins to be seen.
void PointHits::addHighlight(const render::Scene& scene, std::uint32_t layer) {
    const View& view = scene.view;
    const auto& highlight = view.layers[layer].highlight;
    if (!highlight || scene.layers[layer].highlight == nullptr) return;
    const glm::dmat4 layerToEye = view.camera.worldToEye() * view.layers[layer].transform;
    const Depths box = boxDepths(layerToEye);
    const double stands =
        std::max(box.nearest - (box.farthest - box.nearest) / 192.0, nearestDepth(view.camera));
    const Look look{highlight->pointSize.value_or(render::particlesStyleOf(scene, layer).pointSize),
                    highlight->opacity, highlight->color};
    std::vector<glm::dvec3> inEye;
    forPoints(
        *scene.layers[layer].highlight, [](std::size_t) { return 1.0; },
        [&](std::uint64_t point, const glm::dvec3& place) {
            const glm::dvec3 drawn = placeOf_ ? placeOf_(layer, point, place) : place;
            if (cutAway(view.layers[layer], drawn)) return;
            inEye.emplace_back(layerToEye * glm::dvec4(drawn, 1.0));
        });
    const Depths depths = shaded(inEye, box);
    for (const auto& place : inEye) {
        const double along = (-place.z - depths.nearest) / (depths.farthest - depths.nearest);
        addPoint(view, layer, look, place, stands, std::clamp(along, 0.0, 1.0));
    }
}

}  // namespace mote::reference
