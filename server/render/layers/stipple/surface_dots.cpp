// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/surface_dots.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/write_fields.h"
#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

using Range = tbb::blocked_range<std::size_t>;
constexpr std::size_t pointsPerTask = 512;  // points a task: each takes a ray

/// A number from -1 to 1 that is a point's own in every picture (the finaliser of SplitMix64).
double randomOf(std::uint32_t point) {
    std::uint64_t x = (point + 1ULL) * 0x9e3779b97f4a7c15ULL;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ x >> 27) * 0x94d049bb133111ebULL;
    x ^= x >> 31;
    return std::ldexp(static_cast<double>(x >> 11), -52) - 1.0;
}

}  // namespace

SurfaceDots::SurfaceDots(const StippleSurface& surface, const StippleStyle& style, const View& view,
                         const glm::dmat4& transform, HalfSpaces clips)
    : surface_(surface),
      style_(style),
      clips_(std::move(clips)),
      size_(lengthOf(style, style.kDotPixelsFieldNumber)),
      leastSize_(lengthOf(style, style.kLeastDotPixelsFieldNumber)),
      color_(readColor(style.color())),
      view_(view, transform),
      wanted_(surface, style_, view_),
      border_(0.5 * std::max(size_, leastSize_) + 1.0) {
    constexpr std::array names{"", "tone", "depth", "x", "y", "z"};
    value_ = static_cast<Value>(std::find(names.begin(), names.end(), style.value()) - names.begin());
    if (!style.color_map().empty()) colorMap_ = ColorMap::find(style.color_map()).value();
    const glm::dmat4 back = glm::inverse(view_.layerToEye);
    eyeInLayer_ =
        glm::dvec3(back * glm::dvec4(0.0, 0.0, view_.perspective ? 0.0 : 1.0, view_.perspective ? 1.0 : 0.0));
    const Bounds box = surface.bounds().transformed(view_.layerToEye);
    nearestDepth_ = -box.max.z;
    farthestDepth_ = -box.min.z;
}

std::vector<PlacedPoint> SurfaceDots::chosen() const {
    const StippleReplay& replay = surface_.replay();
    return replay.place(replay.select(wanted_.shares()));
}

bool SurfaceDots::visible(std::size_t point, const glm::vec3& position) const {
    if (!inAll(clips_, position)) return false;
    const glm::dvec3 inEye = view_.toEye(position);
    if (!view_.inFront(inEye)) return false;
    const glm::dvec2 at = view_.onScreen(inEye);
    if (!(at.x > -border_ && at.y > -border_ && at.x < view_.size.x + border_ &&
          at.y < view_.size.y + border_)) {
        return false;
    }
    if (style_.see_through()) return true;
    const glm::dvec3 way = view_.perspective ? eyeInLayer_ - glm::dvec3(position) : eyeInLayer_;
    const double length = glm::length(way);
    double near = 0.0, far = view_.perspective ? length : std::numeric_limits<double>::infinity();
    clipWay(clips_, position, way / length, near, far);
    return !surface_.hides(position, surface_.replay().normal(point), glm::vec3(way / length),
                           static_cast<float>(far));
}

std::vector<ShownPoint> SurfaceDots::seen(const std::vector<PlacedPoint>& points) const {
    std::vector<std::uint8_t> visibility(points.size());
    forRangesInTurns(points.size(), pointsPerTask, [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i)
            visibility[i] = visible(points[i].point, points[i].position) ? 1 : 0;
    });
    std::vector<ShownPoint> result;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (visibility[i] != 0) result.push_back({points[i].point, points[i].position});
    }
    return result;
}

Dots SurfaceDots::onScreen(const std::vector<ShownPoint>& points) const {
    Dots dots(points.size());
    forRangesInTurns(points.size(), pointsPerTask, [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i) dots[i] = dotOf(points[i]);
    });
    return dots;
}

/// J = sin(theta) * d / 2 * r * (E x N): dots that foreshortening lines up are moved along the edge
/// (2.2.3.2).
glm::dvec3 SurfaceDots::jittered(const ShownPoint& shown, const glm::dvec3& inEye, float share) const {
    const glm::dvec3 area = view_.areaToEye * glm::dvec3(surface_.replay().normal(shown.point));
    const double scale = glm::length(area);  // square units of eye space in one of layer space
    if (!(share > 0.0F) || !(scale > 0.0)) return inEye;
    const double density = std::min<double>(share, 1.0) * surface_.density() / scale;
    const double distance = std::sqrt(2.0 / (std::numbers::sqrt3 * density));
    const glm::dvec3 across = glm::cross(view_.towardsEye(inEye), area / scale);  // of length sin(theta)
    return inEye + style_.jitter() * 0.5 * distance * randomOf(shown.point) * glm::length(across) * across;
}

float SurfaceDots::valueOf(const ShownPoint& shown, double depth, float tone) const {
    const auto within = [](double value, double low, double high) {
        return high > low ? static_cast<float>(std::clamp((value - low) / (high - low), 0.0, 1.0)) : 0.0F;
    };
    const Bounds& bounds = surface_.bounds();
    const auto along = [&](int axis) {
        return within(shown.position[axis], bounds.min[axis], bounds.max[axis]);
    };
    switch (value_) {
        case Value::tone:
            return tone;
        case Value::depth:
            return within(depth, nearestDepth_, farthestDepth_);
        case Value::x:
            return along(0);
        case Value::y:
            return along(1);
        case Value::z:
            return along(2);
        case Value::none:
            break;
    }
    return 1.0F;
}

Dot SurfaceDots::dotOf(const ShownPoint& shown) const {
    glm::dvec3 inEye = view_.toEye(shown.position);
    WantedDensity::Wanted wanted;
    if (style_.jitter() > 0.0 || value_ == Value::tone) wanted = wanted_.at(shown.point);
    if (style_.jitter() > 0.0) inEye = jittered(shown, inEye, wanted.share);
    const glm::dvec2 at = view_.onScreen(inEye);
    const float value = valueOf(shown, -inEye.z, wanted.tone);
    const double size = leastSize_ + value * (size_ - leastSize_);
    return {.x = static_cast<float>(at.x),
            .y = static_cast<float>(at.y),
            .depth = -inEye.z,
            .radius = static_cast<float>(0.5 * size),
            .opacity = static_cast<float>(style_.opacity()) * shown.presence,
            .color = colorMap_ ? glm::vec3((*colorMap_)(value)) : color_};
}

}  // namespace mote::render
