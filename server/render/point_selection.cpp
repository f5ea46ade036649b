// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/point_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "protocol/scene/drawn_points.h"
#include "server/render/octree_cell.h"
#include "storage/storage_error.h"

namespace mote::render {
namespace {

[[noreturn]] void damaged(const char* array, std::size_t index) {
    throw storage::StorageError(Error{ErrorCode::corrupt,
                                      std::string(array) + "[" + std::to_string(index) + "]",
                                      "the octree refers to something that it does not hold"});
}

Frustum::Side sideOf(const storage::OctreeNodes& nodes, std::size_t i, const Frustum& frustum) {
    if (nodes.level[i] > deepestLevel) damaged("/octree/level", i);
    const double half = std::ldexp(1.0, -nodes.level[i]);
    const glm::dvec3 place(cellPlace(nodes.morton[i]));
    return frustum.of(glm::dvec3(-1.0) + 2.0 * half * (place + 0.5), half);
}

/// The density at scaled log density t, a little raised, so that no leaf is lost by rounding.
double densityAt(const LogDensity& scale, double t) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    if (!(scale.max > scale.min)) return t > 0.0 ? infinite : 0.0;  // all leaves have t = 0
    if (t > 1.0) return infinite;
    return scale.min * std::exp(t * std::log(scale.max / scale.min)) * (1.0 + 1e-6);
}

/// The curve's fraction of leaf after leaf; equal densities, common in a run of equal weights, are looked up
/// once.
class LeafFraction {
  public:
    LeafFraction(const Curve& curve, const LogDensity& scale) : curve_(curve), scale_(scale) {}
    double operator()(float density) {
        if (density != density_) {
            density_ = density;
            fraction_ = curve_(scale_.ofLeaf(density));
        }
        return fraction_;
    }

  private:
    const Curve& curve_;
    LogDensity scale_;
    float density_ = std::numeric_limits<float>::quiet_NaN();
    double fraction_ = 0.0;
};

}  // namespace

double zeroFrom(const Curve& curve) {
    const auto& knots = curve.knots();
    if (knots.back().y > 0.0) return std::numeric_limits<double>::infinity();
    const auto positive = [](const Curve::Knot& knot) { return knot.y > 0.0; };
    const auto last = std::find_if(knots.rbegin(), knots.rend(), positive);
    return last == knots.rend() ? 0.0 : last.base()->x;
}

std::vector<std::uint8_t> visibleLeaves(const storage::ParticleStep& step, const Frustum& frustum,
                                        double densityLimit) {
    const auto nodes = step.nodes();
    std::vector<std::uint8_t> visible(step.leaves().size(), 0);
    // Parents stand before their children, so one pass over the nodes in their order is a traversal.
    std::vector<Frustum::Side> sides(nodes.size(), Frustum::Side::outside);
    if (!sides.empty()) sides[0] = Frustum::Side::partly;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        if (sides[i] == Frustum::Side::outside || nodes.minDensity[i] > densityLimit) continue;
        if (sides[i] == Frustum::Side::partly) sides[i] = sideOf(nodes, i, frustum);
        if (sides[i] == Frustum::Side::outside || nodes.count[i] == 0) continue;
        const std::size_t first = nodes.firstChild[i];
        if (nodes.childCount[i] == 0) {
            if (first >= visible.size()) damaged("/octree/first_child", i);
            visible[first] = 1;
            continue;
        }
        if (first <= i || first + nodes.childCount[i] > nodes.size()) damaged("/octree/first_child", i);
        std::fill_n(sides.begin() + static_cast<std::ptrdiff_t>(first), nodes.childCount[i], sides[i]);
    }
    return visible;
}

std::vector<std::uint32_t> selectPoints(const storage::ParticleStep& step, const Frustum& frustum,
                                        const Curve& pointFraction, double share) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    std::vector<std::uint32_t> drawn(leaves.size(), 0);
    const double limit = densityAt(step.logDensity(), zeroFrom(pointFraction));
    // Leaves ascend in density: beyond the limit there is nothing to draw.
    const auto end = std::upper_bound(leaves.density.begin(), leaves.density.end(), limit);
    const auto count = static_cast<std::size_t>(end - leaves.density.begin());
    const bool all = frustum.of(glm::dvec3(0.0), 1.0) == Frustum::Side::inside;
    const auto visible =
        all || count == 0 ? std::vector<std::uint8_t>() : visibleLeaves(step, frustum, limit);
    LeafFraction fractionOf(pointFraction, step.logDensity());
    for (std::size_t i = 0; i < count; ++i) {
        if (!all && visible[i] == 0) continue;
        const double fraction = share * fractionOf(leaves.density[i]);
        if (!(fraction > 0.0)) continue;
        const std::size_t node = leaves.node[i];
        if (node >= nodes.size()) damaged("/leaves/node", i);
        drawn[i] = fraction >= 1.0
                       ? leaves.pointCount[i]
                       : drawnPoints(fraction, leaves.pointCount[i], nodes.level[node], nodes.morton[node]);
    }
    return drawn;
}

}  // namespace mote::render
