// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/brute_preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "protocol/scene/drawn_points.h"

namespace mote::test {
namespace {

using storage::Preview;
using storage::PreviewPoint;

/// The fraction that draws a point, its leaf, its place in the leaf.
using Drawn = std::tuple<double, std::size_t, std::uint32_t>;

/// The leaf's cell and the 16 bits within it as one number, of which the 16 highest are the place in the box.
std::uint16_t inBox(std::uint64_t morton, unsigned axis, unsigned level, std::uint16_t inCell) {
    std::uint64_t cell = 0;
    for (unsigned bit = 0; bit < level; ++bit) cell |= (morton >> (3 * bit + axis) & 1U) << bit;
    return static_cast<std::uint16_t>((cell * 65536 + inCell) >> level);
}

std::vector<Drawn> inOrder(const storage::ParticleStep& step) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    std::vector<Drawn> order;
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const auto node = leaves.node[leaf];
        const double offset = leafOffset(nodes.level[node], nodes.morton[node]);
        for (std::uint32_t i = 0; i < leaves.pointCount[leaf]; ++i) {
            order.emplace_back((i + 1.0 - offset) / leaves.pointCount[leaf], leaf, i);
        }
    }
    std::sort(order.begin(), order.end());
    order.resize(std::min<std::size_t>(order.size() / 4, Preview::mostPoints));
    return order;
}

LogDensity scaleOf(const storage::ParticleStep& step) {
    LogDensity scale;
    for (const float density : step.leaves().density) {
        if (!(density > 0.0F)) continue;
        if (scale.min == 1.0 && scale.max == 1.0) scale = {density, density};
        scale = {std::min<double>(scale.min, density), std::max<double>(scale.max, density)};
    }
    return scale;
}

}  // namespace

Preview BrutePreview::first(std::uint64_t most) const {
    if (points.empty()) return {};
    const auto shown = std::span(points).first(std::min<std::uint64_t>(most, points.size()));
    return {shown, points.size(), threshold, scale};
}

BrutePreview brutePreview(const storage::ParticleStep& step) {
    BrutePreview preview;
    preview.scale = scaleOf(step);
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    for (const auto& [from, leaf, place] : inOrder(step)) {
        if (preview.points.size() % Preview::blockPoints == 0) {
            preview.threshold.push_back(static_cast<float>(from));
        }
        const auto node = leaves.node[leaf];
        const auto inCell = step.positions(leaves.pointBegin[leaf] + place, 1).front();
        const auto at = [&](unsigned axis, std::uint16_t within) {
            return inBox(nodes.morton[node], axis, nodes.level[node], within);
        };
        const double density = leaves.density[leaf];
        const double t = density > 0.0 ? preview.scale.ofLeaf(density) : 0.0;
        preview.points.push_back({at(0, inCell.x), at(1, inCell.y), at(2, inCell.z),
                                  static_cast<std::uint16_t>(std::lround(65535.0 * t))});
    }
    return preview;
}

}  // namespace mote::test
