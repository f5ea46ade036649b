// SPDX-License-Identifier: GPL-3.0-or-later
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "server/render/screen_dots.h"
#include "server/render/screen_map.h"

namespace mote::render {
namespace {

constexpr std::size_t chunkPoints = 16384;
constexpr double least = 1e-5;  // opacity: a hundred such points show in no picture of 8 bits

/// What the points of a plan have by their codes (docs/PICTURE.md, "Hybrid volumes").
class PointLooks {
  public:
    explicit PointLooks(const HybridPlan& plan, double cell) : opacities_(65536), light_(plan.light) {
        const HybridStep& step = *plan.step;
        for (std::size_t v = 0; v < 256; ++v) {
            const double value =
                step.range.low + static_cast<double>(v) / 255.0 * (step.range.high - step.range.low);
            const double own = plan.transfer.extinction(value);
            colors_[v] = glm::vec3(plan.transfer.color(value));
            for (std::size_t e = 0; e < 256 && own > 0.0; ++e) {
                const double error = (static_cast<double>(e) - 128.0) * step.points->errorStep;
                const double lack = own - plan.transfer.extinction(value - error);
                if (lack > 0.0) opacities_[v * 256 + e] = plan.style.pointOpacity * -std::expm1(-lack * cell);
            }
        }
    }
    double opacity(const HybridPoint& point) const {
        return opacities_[std::size_t{point.value} * 256 + point.error];
    }
    glm::vec3 color(const HybridPoint& point) const {
        const auto& shade = light_.of(point.normal);
        return colors_[point.value] * shade.diffuse + shade.specular;
    }

  private:
    std::vector<double> opacities_;
    std::array<glm::vec3, 256> colors_{};
    const HybridLight& light_;
};

/// Footprints by the spacing of points on the screen; `opacity`: of the point.
void setFootprint(ScreenDot& dot, double spacing, double pointSize, double opacity) {
    const double size = pointSize * spacing;
    if (dot.shape == PointShape::square) {
        const double edge = std::ceil(size);
        const double share = std::min(1.0, spacing * spacing / (edge * edge));
        dot.ink = DotFootprint(static_cast<float>(0.5 * edge), static_cast<float>(opacity * share));
    } else if (dot.shape == PointShape::disc) {
        dot.ink = DotFootprint(static_cast<float>(size * std::numbers::inv_sqrtpi));
        dot.ink.most *= static_cast<float>(opacity * std::min(1.0, 1.0 / (pointSize * pointSize)));
    } else {
        const double deviation = 0.5 * std::max(size, 1.0);
        dot.peak = static_cast<float>(spacing * spacing / (2.0 * std::numbers::pi * deviation * deviation));
        dot.ink = DotFootprint(static_cast<float>(3.0 * deviation), static_cast<float>(opacity));
    }
}

class SplatMaker {
  public:
    SplatMaker(const FramePlan& frame, const HybridPlan& plan)
        : frame_(frame), plan_(plan), toScreen_(boxToScreen(frame, plan.boxToEye)), looks_(plan, cellEdge()) {
        const glm::dmat3 boxToEye(plan.boxToEye);
        const double inEye = std::cbrt(std::abs(glm::determinant(boxToEye)) / samples());
        spacing_ = inEye * frame.height / (2.0 * frame.camera.halfHeight());
    }

    void make(std::size_t begin, std::size_t end, std::vector<ScreenDot>& out) const {
        const HybridPoints& points = *plan_.step->points;
        for (std::size_t i = begin; i < end; ++i) {
            const double opacity = looks_.opacity(points.points[i]);
            if (opacity >= least) add(points.points[i], opacity, out);
        }
    }

  private:
    double samples() const {
        const glm::dvec3 size(plan_.step->points->size);
        return size.x * size.y * size.z;
    }
    /// Of the cube with the volume of a cell of the error grid, layer units.
    double cellEdge() const {
        return std::cbrt(std::abs(glm::determinant(glm::dmat3(plan_.step->boxToLayer))) / samples());
    }
    bool cut(const glm::dvec3& inBox) const {
        return std::any_of(plan_.clips.begin(), plan_.clips.end(), [&](const HalfSpace& side) {
            return glm::dot(side.normal, inBox) < side.distance;
        });
    }
    void add(const HybridPoint& point, double opacity, std::vector<ScreenDot>& out) const {
        const glm::dvec3 inBox =
            (glm::dvec3(point.x, point.y, point.z) + 0.5) / glm::dvec3(plan_.step->points->size);
        const glm::dvec4 at = toScreen_ * glm::dvec4(inBox, 1.0);
        // What is nearer than the plan's nearest depth is not seen.
        if (!(at.z >= 0.0) || !(at.w > 0.0)) return;
        ScreenDot dot{static_cast<float>(at.x / at.w),
                      static_cast<float>(at.y / at.w),
                      DotFootprint(0.0F, 0.0F),
                      static_cast<float>(std::min(at.z, static_cast<double>(frame_.slabs))),
                      {},
                      plan_.style.pointShape};
        setFootprint(dot, spacing_ / at.w, plan_.style.pointSize, opacity);
        const float reach = dot.ink.reach + 1.0F;
        const bool seen = dot.x > -reach && dot.y > -reach &&
                          dot.x < static_cast<float>(frame_.width) + reach &&
                          dot.y < static_cast<float>(frame_.height) + reach;
        if (!seen || cut(inBox)) return;
        dot.color = looks_.color(point);
        out.push_back(dot);
    }

    const FramePlan& frame_;
    const HybridPlan& plan_;
    glm::dmat4 toScreen_;
    PointLooks looks_;
    double spacing_ = 0.0;  // of points, in pixels at depth 1 (perspective) or anywhere
};

}  // namespace

std::vector<ScreenDot> screenSplats(const FramePlan& plan) {
    std::vector<ScreenDot> all;
    for (const auto& hybrid : plan.hybrids) {
        if (!hybrid.hasPoints()) continue;
        const SplatMaker maker(plan, hybrid);
        const std::size_t points = hybrid.step->points->points.size();
        std::vector<std::vector<ScreenDot>> parts((points + chunkPoints - 1) / chunkPoints);
        tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
            maker.make(part * chunkPoints, std::min(points, (part + 1) * chunkPoints), parts[part]);
        });
        for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

}  // namespace mote::render
