// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/lower_particles.h"

#include <cmath>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <memory>
#include <utility>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/length_scale.h"

namespace mote::render {
namespace {

/// Far beyond any picture; what lies farther out is cut, so that its places fit into single precision.
constexpr double farPixels = 1 << 20;

/// Draws the ways one after the other, cut where they go nearer than is seen.
class PathPen {
  public:
    PathPen(const FramePlan& plan, double width, Strokes& out)
        : plan_(plan), nearest_(nearLimit(plan.camera)), width_(static_cast<float>(width)), out_(out) {}

    void begin(const glm::dvec3& inEye) {
        end();
        before_ = inEye;
        if (seen(inEye)) add(inEye);
    }

    void go(const glm::dvec3& inEye) {
        const bool from = seen(before_), to = seen(inEye);
        if (from != to) {
            const double share = (nearest_ + before_.z) / (before_.z - inEye.z);
            add(before_ + share * (inEye - before_));
        }
        if (to) add(inEye);
        if (!to) end();
        before_ = inEye;
    }

    void end() {
        const auto points = static_cast<std::uint32_t>(out_.points.size());
        if (points > first_) out_.lines.push_back({first_, points});
        first_ = points;
    }

  private:
    bool seen(const glm::dvec3& inEye) const { return -inEye.z >= nearest_; }

    void add(const glm::dvec3& inEye) {
        const double depth = plan_.camera.perspective() ? std::max(-inEye.z, nearest_) : -inEye.z;
        const double halfHeight = plan_.camera.halfHeight() * (plan_.camera.perspective() ? depth : 1.0);
        const double pixels = 0.5 * plan_.height / halfHeight;
        const double x = 0.5 * plan_.width + inEye.x * pixels, y = 0.5 * plan_.height - inEye.y * pixels;
        if (!(std::abs(x) < farPixels && std::abs(y) < farPixels)) return end();
        out_.points.push_back({static_cast<float>(x), static_cast<float>(y), width_, depth});
    }

    const FramePlan& plan_;
    const double nearest_;
    const float width_;
    Strokes& out_;
    glm::dvec3 before_{0.0};
    std::uint32_t first_ = 0;
};

}  // namespace

Strokes pathStrokes(const Layer& layer, const proto::Paths& style, const glm::dvec3& pointColor,
                    const PointPaths& paths, const FramePlan& plan, double pixels) {
    Strokes strokes;
    strokes.color = glm::vec3(colorOf(style, style.kColorFieldNumber).value_or(pointColor));
    strokes.opacity = static_cast<float>(layer.opacity);
    PathPen pen(plan, lengthOf(style, style.kWidthFieldNumber) * pixels, strokes);
    const glm::dmat4 toEye = plan.camera.worldToEye() * layer.transform;
    const auto inEye = [&](const glm::dvec3& place) { return glm::dvec3(toEye * glm::dvec4(place, 1.0)); };
    const auto clips = layer.clips();
    for (std::size_t path = 0; path < paths.size(); ++path) {
        const auto first = paths.begin[path], end = paths.begin[path + 1];
        if (first < end && inAll(clips, paths.places[first])) pen.begin(inEye(paths.places[first]));
        for (auto i = first + 1; i < end; ++i) {
            const glm::dvec3 from(paths.places[i - 1]), way = glm::dvec3(paths.places[i]) - from;
            double enter = 0.0, leave = 1.0;
            clipWay(clips, from, way, enter, leave);
            if (enter > 0.0) pen.end();
            if (!(enter <= leave)) continue;
            if (enter > 0.0) pen.begin(inEye(from + enter * way));
            pen.go(inEye(leave < 1.0 ? from + leave * way : from + way));
            if (leave < 1.0) pen.end();
        }
        pen.end();
    }
    return strokes;
}

Strokes pathCasing(Strokes paths, const FramePlan& plan) {
    const auto wider = static_cast<float>(2.0 * plan.height / usualLines);
    for (auto& point : paths.points) point.width += wider;
    paths.color = glm::vec3(plan.background);
    return paths;
}

/// Of equal depths the paths, which come first, lie in front.
void lowerPaths(const Layer& layer, const proto::Paths& style, const glm::dvec3& pointColor,
                const PointPaths& paths, Lowering& out) {
    auto strokes =
        std::make_shared<Strokes>(pathStrokes(layer, style, pointColor, paths, out.plan, out.pixels));
    if (strokes->empty()) return;
    auto casing = std::make_shared<const Strokes>(pathCasing(*strokes, out.plan));
    out.plan.strokes.push_back(std::move(strokes));
    out.plan.strokes.push_back(std::move(casing));
}

}  // namespace mote::render
