// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/lower_highlight.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/mat4x4.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/scene/drawn_points.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/octree_cell.h"

namespace mote::render {
namespace {

constexpr std::size_t blockLeaves = 1024;
constexpr double depthUnits = 16777216.0;  // of the optical depth of a whole point

/// How much of highlighted points each pixel holds; whole numbers, so that their order does not matter.
class HighlightSums {
  public:
    HighlightSums(const FramePlan& plan, const PointLook& look)
        : width_(plan.width),
          height_(plan.height),
          camera_(plan.camera),
          nearest_(nearLimit(plan.camera)),
          size_(look.size),
          opacity_(look.opacity),
          whole_(-std::log1p(-look.opacity)),
          sums_(std::size_t{plan.width} * plan.height, 0) {}

    void add(const glm::dvec3& inEye) {
        const double depth = -inEye.z;
        const double halfHeight = camera_.halfHeight() * (camera_.perspective() ? depth : 1.0);
        if (depth < nearest_ || !(halfHeight > 0.0)) return;
        const double halfWidth = halfHeight * width_ / height_;
        const double x = 0.5 * (inEye.x / halfWidth + 1.0) * width_;
        const double y = 0.5 * (1.0 - inEye.y / halfHeight) * height_;
        if (size_ > 1.0) return addDisc(x, y);
        if (!(x >= 0.0 && x < width_ && y >= 0.0 && y < height_)) return;
        addTo(static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x), size_ * size_);
    }

    /// Optical depth, before it is thinned.
    double depthAt(std::size_t pixel) const {
        return static_cast<double>(sums_[pixel]) * (whole_ / depthUnits);
    }
    std::uint32_t width() const { return width_; }
    std::size_t pixels() const { return sums_.size(); }

  private:
    void addDisc(double x, double y) {
        const double reach = 0.5 * size_ + 0.5;
        const auto first = [&](double at) { return std::max(std::floor(at - reach), 0.0); };
        const auto end = [&](double at, std::uint32_t side) {
            return std::min<double>(std::ceil(at + reach), side);
        };
        for (double row = first(y); row < end(y, height_); ++row) {
            for (double column = first(x); column < end(x, width_); ++column) {
                const double away = std::hypot(column + 0.5 - x, row + 0.5 - y);
                const double coverage = std::clamp(reach - away, 0.0, 1.0);
                addTo(static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column), coverage);
            }
        }
    }

    void addTo(std::size_t pixel, double coverage) {
        const double share = -std::log1p(-opacity_ * coverage) / whole_;
        std::atomic_ref(sums_[pixel])
            .fetch_add(static_cast<std::uint64_t>(std::lround(share * depthUnits)),
                       std::memory_order_relaxed);
    }

    std::uint32_t width_, height_;
    const Camera& camera_;
    double nearest_, size_, opacity_, whole_;
    std::vector<std::uint64_t> sums_;
};

void addPoints(const storage::ParticleStep& step, const glm::dmat4& boxToEye, double share,
               HighlightSums& sums) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    forRangesInTurns(leaves.size(), blockLeaves, [&](const auto& block) {
        for (std::size_t leaf = block.begin(); leaf < block.end(); ++leaf) {
            const auto node = leaves.node[leaf];
            const double edge = std::ldexp(1.0, -nodes.level[node]);
            const glm::dvec3 corner(cellPlace(nodes.morton[node]));
            const auto drawn =
                drawnPoints(share, leaves.pointCount[leaf], nodes.level[node], nodes.morton[node]);
            for (const auto& p : step.positions(leaves.pointBegin[leaf], drawn)) {
                const glm::dvec3 inBox = (corner + (glm::dvec3(p.x, p.y, p.z) + 0.5) / 65536.0) * edge;
                sums.add(glm::dvec3(boxToEye * glm::dvec4(inBox, 1.0)));
            }
        }
    });
}

}  // namespace

void lowerHighlight(const Layer& layer, const Highlight& highlight, const ParticlesStyle& style,
                    const storage::ParticleStep& points, const Bounds& inEye, Lowering& out) {
    FramePlan& plan = out.plan;
    // A slab of an exact picture before the box, so that none of the layer's own points is mixed with them.
    const double nearest = -inEye.max.z, farthest = -inEye.min.z;
    const double depth = std::max(nearest - (farthest - nearest) / 192.0, nearLimit(plan.camera));
    if (!(farthest > depth) || !(highlight.opacity > 0.0)) return;
    const double share = out.quality.pointFraction;
    const PointLook look{.size = highlight.pointSize.value_or(style.pointSize) * out.pixels,
                         .opacity = std::min(-std::expm1(std::log1p(-highlight.opacity) / share),
                                             TransferFunction::opacityLimit)};
    HighlightSums sums(plan, look);
    addPoints(points, plan.camera.worldToEye() * layer.transform * plotToLayer(), share, sums);
    auto fragments = std::make_shared<Fragments>();
    for (std::size_t pixel = 0; pixel < sums.pixels(); ++pixel) {
        const auto opacity = static_cast<float>(-std::expm1(-layer.opacity * sums.depthAt(pixel)));
        if (!(opacity > 0.0F)) continue;
        fragments->push_back({static_cast<std::uint32_t>(pixel % sums.width()),
                              static_cast<std::uint32_t>(pixel / sums.width()), depth, opacity,
                              glm::vec3(highlight.color)});
    }
    if (fragments->empty()) return;
    plan.fragments.push_back(std::move(fragments));
    out.addDots(depth, depth);
}

}  // namespace mote::render
