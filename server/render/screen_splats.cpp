// SPDX-License-Identifier: GPL-3.0-or-later
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <numeric>

#include "server/render/screen_dots.h"
#include "server/render/screen_map.h"

namespace mote::render {
namespace {

constexpr std::uint32_t chunkPoints = 16384;
constexpr double least = 1e-5;  // opacity: a hundred such points show in no picture of 8 bits

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
    SplatMaker(const FramePlan& frame, const HybridPlan& plan, const PointLooks& looks)
        : frame_(frame), plan_(plan), looks_(looks), toScreen_(boxToScreen(frame, plan.boxToEye)) {
        const glm::dmat3 boxToEye(plan.boxToEye);
        const double inEye = std::cbrt(std::abs(glm::determinant(boxToEye)) / samples());
        spacing_ = plan.pointGrowth() * inEye * frame.height / (2.0 * frame.camera.halfHeight());
    }

    void make(std::uint32_t begin, std::uint32_t end, std::vector<ScreenDot>& out) const {
        for (std::uint32_t i = begin; i < end; ++i) {
            const HybridPoint& point = plan_.step->points->points[plan_.point(i)];
            const double opacity = plan_.style.pointOpacity * looks_.opacity(point);
            if (opacity >= least) add(point, opacity, out);
        }
    }

  private:
    double samples() const {
        const glm::dvec3 size(plan_.step->points->size);
        return size.x * size.y * size.z;
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
        const auto& shade = plan_.light.of(point.normal);
        dot.color = looks_.color(point) * shade.diffuse + shade.specular;
        out.push_back(dot);
    }

    const FramePlan& frame_;
    const HybridPlan& plan_;
    const PointLooks& looks_;
    glm::dmat4 toScreen_;
    double spacing_ = 0.0;  // of points, in pixels at depth 1 (perspective) or anywhere
};

}  // namespace

void addScreenSplats(const FramePlan& plan, std::vector<KeptPointLooks>& looks,
                     std::vector<ScreenDot>& dots) {
    looks.resize(plan.hybrids.size());
    for (std::size_t layer = 0; layer < plan.hybrids.size(); ++layer) {
        const HybridPlan& hybrid = plan.hybrids[layer];
        if (hybrid.pointCount() == 0) continue;
        const SplatMaker maker(plan, hybrid, looks[layer].of(hybrid));
        const std::uint32_t points = hybrid.pointCount();
        const std::uint32_t chunks = (points + chunkPoints - 1) / chunkPoints;
        tbb::enumerable_thread_specific<std::vector<ScreenDot>> seen;
        // Twice, to count and to place: keeping them in between takes longer, and as much memory again.
        const auto forChunks = [&](auto visit) {
            tbb::parallel_for(0U, chunks, [&](std::uint32_t chunk) {
                auto& some = seen.local();
                some.clear();
                maker.make(chunk * chunkPoints, std::min(points, (chunk + 1) * chunkPoints), some);
                visit(chunk, some);
            });
        };
        std::vector<std::size_t> begin(chunks + 1, dots.size());
        forChunks([&](std::uint32_t chunk, const auto& some) { begin[chunk + 1] = some.size(); });
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        dots.resize(begin.back());
        forChunks([&](std::uint32_t chunk, const auto& some) {
            std::copy(some.begin(), some.end(), dots.begin() + static_cast<std::ptrdiff_t>(begin[chunk]));
        });
    }
}

}  // namespace mote::render
