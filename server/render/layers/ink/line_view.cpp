// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/line_view.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace mote::render {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Keeps of a span where a value that changes linearly along a line is at least 0.
void keepWhere(Span& span, double atBegin, double atEnd) {
    if (atBegin >= 0.0 && atEnd >= 0.0) return;
    if (atBegin < 0.0 && atEnd < 0.0) {
        span.end = -infinity;
        return;
    }
    const double crossing = atBegin / (atBegin - atEnd);
    if (atBegin < 0.0) span.begin = std::max(span.begin, crossing);
    if (atEnd < 0.0) span.end = std::min(span.end, crossing);
}

}  // namespace

LineView::LineView(const FramePlan& plan, const glm::dmat4& transform)
    : perspective_(plan.camera.perspective()),
      nearest_(nearLimit(plan.camera)),
      size_(plan.width, plan.height),
      pixels_(plan.height / (2.0 * plan.camera.halfHeight())),
      toEye_(plan.camera.worldToEye() * transform),
      fromEye_(glm::inverse(toEye_)),
      eye_(fromEye_ * glm::dvec4(0.0, 0.0, 0.0, 1.0)),
      direction_(glm::dmat3(fromEye_) * glm::dvec3(0.0, 0.0, 1.0)) {}

glm::dvec3 LineView::toEye(const glm::dvec3& inLayer) const {
    return glm::dvec3(toEye_ * glm::dvec4(inLayer, 1.0));
}

glm::dvec2 LineView::onScreen(const glm::dvec3& inEye) const {
    return 0.5 * size_ + pixels_ / (perspective_ ? -inEye.z : 1.0) * glm::dvec2(inEye.x, -inEye.y);
}

double LineView::facing(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const {
    return glm::dot(glm::cross(b - a, c - a), perspective_ ? eye_ - a : direction_);
}

glm::dvec3 LineView::wayToEye(const glm::dvec3& inLayer) const {
    return glm::normalize(perspective_ ? eye_ - inLayer : direction_);
}

Span LineView::inPicture(const glm::dvec3& from, const glm::dvec3& to, double margin) const {
    Span span{0.0, 1.0};
    keepWhere(span, -from.z - nearest_, -to.z - nearest_);
    const glm::dvec2 half = (0.5 * size_ + margin) / pixels_;
    for (int axis = 0; axis < 2; ++axis) {
        const double first = perspective_ ? -half[axis] * from.z : half[axis];
        const double last = perspective_ ? -half[axis] * to.z : half[axis];
        keepWhere(span, first - from[axis], last - to[axis]);
        keepWhere(span, first + from[axis], last + to[axis]);
    }
    return span;
}

double LineView::alongLine(const glm::dvec3& from, const glm::dvec3& to, double onScreen) const {
    if (!perspective_) return onScreen;
    return onScreen * from.z / (to.z + onScreen * (from.z - to.z));
}

double LineView::alongScreen(const glm::dvec3& from, const glm::dvec3& to, double alongLine) const {
    if (!perspective_) return alongLine;
    return alongLine * to.z / (from.z + alongLine * (to.z - from.z));
}

double LineView::scale() const {
    const glm::dmat3 linear(toEye_);
    return std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
}

MeshRay LineView::towardsEye(const glm::dvec3& inEye, double gap) const {
    const glm::dvec3 from(fromEye_ * glm::dvec4(inEye, 1.0));
    const glm::dvec3 way = perspective_ ? eye_ - from : direction_;
    const double depth = -inEye.z;
    const double leave = perspective_ ? 1.0 - nearest_ / depth : depth - nearest_;
    return {from, way, gap / glm::length(way), leave};
}

MeshRay LineView::fromEye(const glm::dvec3& inEye, double gap) const {
    if (!perspective_) return towardsEye(inEye, gap);
    const glm::dvec3 way = glm::dvec3(fromEye_ * glm::dvec4(inEye, 1.0)) - eye_;
    return {eye_, way, nearest_ / -inEye.z, 1.0 - gap / glm::length(way)};
}

MeshRay LineView::through(const glm::dvec2& place) const {
    const glm::dvec2 window = glm::dvec2(place.x - 0.5 * size_.x, 0.5 * size_.y - place.y) / pixels_;
    const glm::dvec3 origin = perspective_ ? glm::dvec3(0.0) : glm::dvec3(window, 0.0);
    const glm::dvec3 perDepth = perspective_ ? glm::dvec3(window, -1.0) : glm::dvec3(0.0, 0.0, -1.0);
    return {glm::dvec3(fromEye_ * glm::dvec4(origin, 1.0)), glm::dmat3(fromEye_) * perDepth, nearest_,
            infinity};
}

/// The normal of the plane through two places and along the lines of sight there.
glm::dvec3 LineView::throughEye(const glm::dvec3& a, const glm::dvec3& b) const {
    return glm::cross(perspective_ ? a : glm::dvec3(0.0, 0.0, 1.0), perspective_ ? b : b - a);
}

Span LineView::hidden(const glm::dvec3& from, const glm::dvec3& to,
                      const std::array<glm::dvec3, 3>& triangle) const {
    Span span{0.0, 1.0};
    const glm::dvec3 area = glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    const double turned = glm::dot(area, perspective_ ? triangle[0] : glm::dvec3(0.0, 0.0, -1.0));
    if (turned == 0.0) return {};
    // Seen from the eye its corners go one way round or the other.
    const double side = perspective_ ? (turned > 0.0 ? 1.0 : -1.0) : (turned > 0.0 ? -1.0 : 1.0);
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3 plane = side * throughEye(triangle[i], triangle[(i + 1) % 3]);
        const glm::dvec3 origin = perspective_ ? glm::dvec3(0.0) : triangle[i];
        keepWhere(span, glm::dot(plane, from - origin), glm::dot(plane, to - origin));
    }
    const glm::dvec3 away = turned > 0.0 ? area : -area;
    keepWhere(span, glm::dot(away, from - triangle[0]), glm::dot(away, to - triangle[0]));
    if (!perspective_) return span;
    // Where the triangle itself is too near to be seen it hides nothing.
    const auto depth = [&](const glm::dvec3& place) {
        return -place.z - nearest_ * glm::dot(area, place) / turned;
    };
    keepWhere(span, depth(from), depth(to));
    return span;
}

}  // namespace mote::render
