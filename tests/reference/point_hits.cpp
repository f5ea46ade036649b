// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/point_hits.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <tuple>

#include "protocol/scene/drawn_points.h"

namespace mote::reference {
namespace {

// Written down once more, not taken from the devices' frame plan: see docs/PICTURE.md.
constexpr double nearShare = 1e-3;

// Single precision places a point in a picture of some hundred pixels to about 1e-4 of a pixel (2^-24 of 500
// pixels, a handful of operations); ten times that is beyond doubt.
constexpr double doubtfulPixels = 1e-3;

/// Every third bit of a Morton code: a cell's place along one axis.
double placeOf(std::uint64_t morton, int axis) {
    double place = 0.0;
    for (int bit = 0; bit < 21; ++bit) {
        if (morton >> (3 * bit + axis) & 1U) place += std::ldexp(1.0, bit);
    }
    return place;
}

bool inside(double value, std::uint32_t size) {
    return value >= 0.0 && value < size;
}

}  // namespace

double nearestDepth(const Camera& camera) {
    if (!camera.perspective()) return -std::numeric_limits<double>::infinity();
    return std::max(nearShare * glm::length(camera.target - camera.eye), 0.0);
}

PointHits::PointHits(const render::Scene& scene) {
    const std::size_t pixels = std::size_t{scene.view.width} * scene.view.height;
    ambiguous_.assign(pixels, 0);
    for (std::uint32_t layer = 0; layer < scene.view.layers.size(); ++layer) {
        if (scene.view.layers[layer].particles() != nullptr) addLayer(scene, layer);
    }
    if (scene.dots != nullptr) addDots(scene);
    sort(pixels);
}

void PointHits::addLayer(const render::Scene& scene, std::uint32_t layer) {
    const View& view = scene.view;
    const storage::ParticleStep& step = *scene.steps[layer];
    const ParticlesStyle& style = *view.layers[layer].particles();
    const glm::dmat4 layerToEye = view.camera.worldToEye() * view.layers[layer].transform;
    const LogDensity scale = step.logDensity();
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const auto node = leaves.node[leaf];
        const double fraction = style.pointFraction(scale.ofLeaf(leaves.density[leaf]));
        const auto drawn =
            drawnPoints(fraction, leaves.pointCount[leaf], nodes.level[node], nodes.morton[node]);
        const glm::dvec3 corner(placeOf(nodes.morton[node], 0), placeOf(nodes.morton[node], 1),
                                placeOf(nodes.morton[node], 2));
        for (const auto& p : step.positions(leaves.pointBegin[leaf], drawn)) {
            const glm::dvec3 inCell = (glm::dvec3(p.x, p.y, p.z) + 0.5) / 65536.0;
            const glm::dvec3 inBox = (corner + inCell) * std::ldexp(1.0, -nodes.level[node]);
            const glm::dvec3 inLayer = 2.0 * inBox - 1.0;
            addPoint(view, layer, glm::dvec3(layerToEye * glm::dvec4(inLayer, 1.0)));
        }
    }
}

/// The disc's edge is softened over a pixel around a radius so chosen that its ink is that of the disc.
void PointHits::addDots(const render::Scene& scene) {
    const View& view = scene.view;
    auto number = static_cast<std::uint32_t>(view.layers.size());
    for (const auto& dot : *scene.dots) {
        const double radius = dot.radius, x = dot.x, y = dot.y;
        const double soft = std::sqrt(std::max(radius * radius, 1.0 / 3.0) - 1.0 / 12.0);
        Hit hit{0, number++, dot.depth, dot.opacity * std::min(1.0, 3.0 * radius * radius), dot.color};
        const bool near = std::isfinite(dot.depth) && dot.depth < nearestDepth(view.camera);
        if (!near && hit.alpha > 0.0) addDisc(view, hit, x, y, 2.0 * soft);
    }
}

void PointHits::addPoint(const View& view, std::uint32_t layer, const glm::dvec3& inEye) {
    const double depth = -inEye.z;
    const ParticlesStyle& style = *view.layers[layer].particles();
    if (depth < nearestDepth(view.camera) || !(style.pointOpacity > 0.0)) return;
    const double halfHeight = view.camera.halfHeight() * (view.camera.perspective() ? depth : 1.0);
    const double halfWidth = halfHeight * view.aspect();
    const double px = 0.5 * (inEye.x / halfWidth + 1.0) * view.width;
    const double py = 0.5 * (1.0 - inEye.y / halfHeight) * view.height;
    const Hit hit{0, layer, depth, style.pointOpacity, style.pointColor};
    if (style.pointSize <= 1.0) {
        addSquare(view, hit, px, py, style.pointSize);
    } else {
        addDisc(view, hit, px, py, style.pointSize);
    }
}

void PointHits::addSquare(const View& view, Hit hit, double px, double py, double size) {
    markAmbiguous(view, px, py);
    if (!inside(px, view.width) || !inside(py, view.height)) return;
    hit.pixel = static_cast<std::uint32_t>(py) * view.width + static_cast<std::uint32_t>(px);
    hit.alpha *= size * size;
    hits_.push_back(hit);
}

void PointHits::addDisc(const View& view, Hit hit, double px, double py, double size) {
    const double reach = 0.5 * size + 0.5;
    const double opacity = hit.alpha;
    const auto first = [&](double p) { return std::max(std::floor(p - reach - 0.5), 0.0); };
    const auto end = [&](double p, double side) { return std::min(std::ceil(p + reach + 0.5), side); };
    for (double row = first(py); row < end(py, view.height); ++row) {
        for (double column = first(px); column < end(px, view.width); ++column) {
            const double distance = std::hypot(column + 0.5 - px, row + 0.5 - py);
            const double coverage = std::clamp(reach - distance, 0.0, 1.0);
            if (coverage <= 0.0) continue;
            hit.pixel = static_cast<std::uint32_t>(row) * view.width + static_cast<std::uint32_t>(column);
            hit.alpha = opacity * coverage;
            hits_.push_back(hit);
        }
    }
}

void PointHits::markAmbiguous(const View& view, double px, double py) {
    const double x[] = {std::floor(px - doubtfulPixels), std::floor(px + doubtfulPixels)};
    const double y[] = {std::floor(py - doubtfulPixels), std::floor(py + doubtfulPixels)};
    if (x[0] == x[1] && y[0] == y[1]) return;
    for (const double row : y) {
        for (const double column : x) {
            if (!inside(column, view.width) || !inside(row, view.height)) continue;
            ambiguous_[static_cast<std::size_t>(row) * view.width + static_cast<std::size_t>(column)] = 1;
        }
    }
}

void PointHits::sort(std::size_t pixels) {
    // Points of one layer at one depth commute.
    std::stable_sort(hits_.begin(), hits_.end(), [](const Hit& a, const Hit& b) {
        return std::tie(a.pixel, a.depth, a.layer) < std::tie(b.pixel, b.depth, b.layer);
    });
    begin_.assign(pixels + 1, 0);
    for (const auto& hit : hits_) ++begin_[hit.pixel + 1];
    for (std::size_t i = 0; i < pixels; ++i) begin_[i + 1] += begin_[i];
}

}  // namespace mote::reference
