// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/clip_path.h"

#include <cmath>
#include <numbers>

namespace mote::server {
namespace {

constexpr int discCorners = 32;

/// What lies where sign * (place[axis] - at) >= 0.
std::vector<glm::dvec2> cutAt(std::span<const glm::dvec2> path, int axis, double at, double sign) {
    std::vector<glm::dvec2> kept;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const auto &from = path[i == 0 ? path.size() - 1 : i - 1], &to = path[i];
        const double before = sign * (from[axis] - at), here = sign * (to[axis] - at);
        if ((before >= 0.0) != (here >= 0.0)) {
            glm::dvec2 crossing = from + before / (before - here) * (to - from);
            crossing[axis] = at;
            kept.push_back(crossing);
        }
        if (here >= 0.0) kept.push_back(to);
    }
    return kept;
}

}  // namespace

std::vector<glm::dvec2> clipped(std::span<const glm::dvec2> path, const ClipBox& box) {
    std::vector<glm::dvec2> kept(path.begin(), path.end());
    for (int axis = 0; axis < 2; ++axis) {
        kept = cutAt(kept, axis, box.low[axis], 1.0);
        kept = cutAt(kept, axis, box.high[axis], -1.0);
    }
    if (kept.size() < 3) kept.clear();
    return kept;
}

std::vector<glm::dvec2> discPath(double radius) {
    constexpr double turn = 2.0 * std::numbers::pi / discCorners;
    const double corner = radius * std::sqrt(turn / std::sin(turn));
    std::vector<glm::dvec2> path;
    for (int i = 0; i < discCorners; ++i)
        path.emplace_back(corner * std::cos(i * turn), corner * std::sin(i * turn));
    return path;
}

}  // namespace mote::server
