// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/box_edges.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace mote::server {
namespace {

/// A corner of the box, by a sign an axis: -1 or 1.
using Signs = std::array<int, 3>;

glm::dvec3 cornerOf(const glm::dmat4& layerToEye, const Signs& signs) {
    return glm::dvec3(layerToEye * glm::dvec4(signs[0], signs[1], signs[2], 1.0));
}

/// Whether the side of an axis is seen from outside. One that is seen edge-on is not.
bool seen(const glm::dmat4& layerToEye, bool perspective, int axis, int sign) {
    const glm::dvec3 right(layerToEye[(axis + 1) % 3]), above(layerToEye[(axis + 2) % 3]);
    const glm::dvec3 out = static_cast<double>(sign) * glm::dvec3(layerToEye[axis]);
    glm::dvec3 normal = glm::cross(right, above);
    if (glm::dot(normal, out) < 0.0) normal = -normal;
    const glm::dvec3 place = glm::dvec3(layerToEye[3]) + out;
    const glm::dvec3 towardsEye = perspective ? -place : glm::dvec3(0.0, 0.0, 1.0);
    constexpr double edgeOn = 1e-6;
    return glm::dot(normal, towardsEye) > edgeOn * glm::length(normal) * glm::length(towardsEye);
}

/// The share of an edge that lies in the picture (Liang and Barsky 1984, in homogeneous coordinates).
void clip(BoxEdge& edge, const Projection& projection, const Box& picture) {
    double from = 0.0, to = 1.0;
    // Keeps where a linear function is not negative.
    const auto keep = [&](double atLow, double atHigh) {
        if (atLow < 0.0 && atHigh < 0.0) to = -1.0;
        if ((atLow < 0.0) == (atHigh < 0.0)) return;
        const double share = atLow / (atLow - atHigh);
        if (atLow < 0.0)
            from = std::max(from, share);
        else
            to = std::min(to, share);
    };
    // A pixel is where p / depth stands to the picture's sides.
    const double depthLow = projection.perspective() ? -edge.low.z : 1.0;
    const double depthHigh = projection.perspective() ? -edge.high.z : 1.0;
    if (projection.perspective()) keep(depthLow - projection.nearDepth(), depthHigh - projection.nearDepth());
    const glm::dvec2 half = 0.5 * picture.size() * projection.pixelSize(1.0);
    for (int i = 0; i < 2; ++i) {
        keep(half[i] * depthLow - edge.low[i], half[i] * depthHigh - edge.high[i]);
        keep(half[i] * depthLow + edge.low[i], half[i] * depthHigh + edge.high[i]);
    }
    edge.from = from;
    edge.to = to;
}

}  // namespace

BoxInPicture boxInPicture(const glm::dmat4& layerToEye, const Projection& projection, const Box& picture) {
    std::array<std::array<bool, 2>, 3> shown{};
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side)
            shown[axis][side] = seen(layerToEye, projection.perspective(), axis, 2 * side - 1);
    }
    BoxInPicture box{};
    bool tooNear = false;
    int corners = 0;
    std::size_t index = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int corner = 0; corner < 4; ++corner, ++index) {
            BoxEdge& edge = box.edges[index];
            Signs signs{};
            const int sideU = corner & 1, sideV = corner >> 1;
            signs[u] = 2 * sideU - 1;
            signs[v] = 2 * sideV - 1;
            edge.axis = axis;
            signs[axis] = -1;
            edge.low = cornerOf(layerToEye, signs);
            signs[axis] = 1;
            edge.high = cornerOf(layerToEye, signs);
            const int sides = (shown[u][sideU] ? 1 : 0) + (shown[v][sideV] ? 1 : 0);
            edge.kind = sides == 1   ? BoxEdge::Kind::outline
                        : sides == 2 ? BoxEdge::Kind::front
                                     : BoxEdge::Kind::back;
            clip(edge, projection, picture);
            if (edge.kind != BoxEdge::Kind::outline) continue;
            for (const auto& end : {edge.low, edge.high}) {
                if (-end.z <= projection.nearDepth()) {
                    tooNear = true;
                    continue;
                }
                box.middle += projection.pixel(end);
                ++corners;
            }
        }
    }
    box.outlined = corners > 0 && !tooNear;
    if (corners > 0) box.middle /= corners;
    return box;
}

}  // namespace mote::server
