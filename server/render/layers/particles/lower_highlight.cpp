// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/lower_particles.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/mat4x4.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "protocol/scene/drawn_points.h"
#include "server/render/layers/particles/moving_look.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/octree_cell.h"

namespace mote::render {
namespace {

constexpr std::size_t blockLeaves = 1024;
constexpr double depthUnits = 16777216.0;  // of the optical depth of a whole point

/// Calls take(place in eye space) for the drawn points, in any order.
template <class Take>
void forDrawn(const storage::ParticleStep& step, const glm::dmat4& boxToEye, double share, Take& take) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    forRangesInTurns(leaves.size(), blockLeaves, [&](const auto& block) {
        auto&& taken = take.begin();
        for (std::size_t leaf = block.begin(); leaf < block.end(); ++leaf) {
            const auto node = leaves.node[leaf];
            const double edge = std::ldexp(1.0, -nodes.level[node]);
            const glm::dvec3 corner(cellPlace(nodes.morton[node]));
            const auto drawn =
                drawnPoints(share, leaves.pointCount[leaf], nodes.level[node], nodes.morton[node]);
            for (const auto& p : step.positions(leaves.pointBegin[leaf], drawn)) {
                const glm::dvec3 inBox = (corner + (glm::dvec3(p.x, p.y, p.z) + 0.5) / 65536.0) * edge;
                taken.add(glm::dvec3(boxToEye * glm::dvec4(inBox, 1.0)));
            }
        }
    });
}

/// Between which depths the points are shaded (docs/PICTURE.md, "Highlights").
struct ShadedDepths {
    double nearest, farthest;

    /// 0 at the near end, 1 at the far one.
    double share(double depth) const {
        return std::clamp((depth - nearest) / (farthest - nearest), 0.0, 1.0);
    }
};

/// The mean of the points' depths and how they spread; whole numbers, so that their order does not matter.
class DepthMoments {
  public:
    /// The depths of the layer's box.
    DepthMoments(double nearest, double farthest) : nearest_(nearest), all_(farthest - nearest) {}

    /// Of the points of some leaves.
    class Part {
      public:
        explicit Part(DepthMoments& whole) : whole_(whole) {}
        Part(const Part&) = delete;
        Part& operator=(const Part&) = delete;
        ~Part() {
            whole_.count_.fetch_add(count_, std::memory_order_relaxed);
            whole_.sum_.fetch_add(sum_, std::memory_order_relaxed);
            whole_.square_.fetch_add(square_, std::memory_order_relaxed);
        }
        void add(const glm::dvec3& inEye) {
            const double share = std::clamp((-inEye.z - whole_.nearest_) / whole_.all_, 0.0, 1.0);
            const auto place = static_cast<std::uint64_t>(share * units + 0.5);
            ++count_;
            sum_ += place;
            square_ += place * place;
        }

      private:
        DepthMoments& whole_;
        std::uint64_t count_ = 0, sum_ = 0, square_ = 0;
    };
    Part begin() { return Part(*this); }

    /// From two standard deviations before the mean to one behind it: what is seen of a body lies there. No
    /// deviation is less than a 64th of the box.
    ShadedDepths shaded() const {
        constexpr double before = 2.0, behind = 1.0, least = 1.0 / 64.0;
        const double count = std::max(static_cast<double>(count_.load()), 1.0);
        const double mean = static_cast<double>(sum_.load()) / count / units;
        const double square = static_cast<double>(square_.load()) / count / (units * units);
        const double deviation = std::max(std::sqrt(std::max(square - mean * mean, 0.0)), least);
        return {nearest_ + all_ * (mean - before * deviation), nearest_ + all_ * (mean + behind * deviation)};
    }

  private:
    static constexpr double units = 32768.0;  // of the box's depth: squares of 2^34 points can be summed

    double nearest_, all_;
    std::atomic<std::uint64_t> count_{0}, sum_{0}, square_{0};
};

/// How much of highlighted points each pixel holds, and which depth is the least; whole numbers, so that
/// their order does not matter.
class HighlightSums {
  public:
    HighlightSums(const FramePlan& plan, const PointLook& look, const ShadedDepths& shaded)
        : width_(plan.width),
          height_(plan.height),
          camera_(plan.camera),
          nearest_(nearLimit(plan.camera)),
          size_(look.size),
          opacity_(look.opacity),
          whole_(-std::log1p(-look.opacity)),
          shaded_(shaded),
          pixels_(std::size_t{plan.width} * plan.height) {}

    HighlightSums& begin() { return *this; }

    void add(const glm::dvec3& inEye) {
        const double depth = -inEye.z;
        const double halfHeight = camera_.halfHeight() * (camera_.perspective() ? depth : 1.0);
        if (depth < nearest_ || !(halfHeight > 0.0)) return;
        const double halfWidth = halfHeight * width_ / height_;
        const double x = 0.5 * (inEye.x / halfWidth + 1.0) * width_;
        const double y = 0.5 * (1.0 - inEye.y / halfHeight) * height_;
        const auto place = static_cast<std::uint64_t>(shaded_.share(depth) * depthPlaces + 0.5);
        if (size_ > 1.0) return addDisc(x, y, place);
        if (!(x >= 0.0 && x < width_ && y >= 0.0 && y < height_)) return;
        addTo(static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x), size_ * size_, place);
    }

    /// Optical depth, before it is thinned.
    double depthAt(std::size_t pixel) const {
        return static_cast<double>(pixels_[pixel].sum) * (whole_ / depthUnits);
    }
    /// What the colour is times there.
    double shadeAt(std::size_t pixel) const {
        constexpr double darkest = 0.25;
        const double place = static_cast<double>(pixels_[pixel].least & ~little) / depthPlaces;
        return 1.0 - (1.0 - darkest) * std::min(place, 1.0);
    }
    std::uint32_t width() const { return width_; }
    bool any() const {
        return std::any_of(pixels_.begin(), pixels_.end(), [](const Pixel& one) { return one.sum > 0; });
    }

  private:
    struct Pixel {
        std::uint64_t sum = 0;
        std::uint64_t least = ~std::uint64_t{0};  ///< place in depth of the point that shades it
    };
    static constexpr double depthPlaces = 16777216.0;
    static constexpr std::uint64_t little = std::uint64_t{1} << 62;  // covers less than half of the pixel

    void addDisc(double x, double y, std::uint64_t place) {
        const double reach = 0.5 * size_ + 0.5;
        const auto first = [&](double at) { return std::max(std::floor(at - reach), 0.0); };
        const auto end = [&](double at, std::uint32_t side) {
            return std::min<double>(std::ceil(at + reach), side);
        };
        for (double row = first(y); row < end(y, height_); ++row) {
            for (double column = first(x); column < end(x, width_); ++column) {
                const double away = std::hypot(column + 0.5 - x, row + 0.5 - y);
                const double coverage = std::clamp(reach - away, 0.0, 1.0);
                if (!(coverage > 0.0)) continue;
                addTo(static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column), coverage,
                      coverage < 0.5 ? place | little : place);
            }
        }
    }

    void addTo(std::size_t pixel, double coverage, std::uint64_t place) {
        const double share = -std::log1p(-opacity_ * coverage) / whole_;
        std::atomic_ref(pixels_[pixel].sum)
            .fetch_add(static_cast<std::uint64_t>(std::lround(share * depthUnits)),
                       std::memory_order_relaxed);
        const std::atomic_ref least(pixels_[pixel].least);
        auto present = least.load(std::memory_order_relaxed);
        while (place < present && !least.compare_exchange_weak(present, place, std::memory_order_relaxed)) {
        }
    }

    std::uint32_t width_, height_;
    Camera camera_;
    double nearest_, size_, opacity_, whole_;
    ShadedDepths shaded_;
    std::vector<Pixel> pixels_;
};

/// What they are in each pixel.
class HighlightFragments : public FragmentMaker {
  public:
    HighlightFragments(HighlightSums sums, const glm::dvec3& color, double opacity, double depth)
        : sums_(std::move(sums)), color_(color), opacity_(opacity), depth_(depth) {}

    void make(const PixelRect& pixels, Fragments& fragments) const override {
        for (auto row = pixels.top; row < pixels.bottom; ++row) {
            for (auto column = pixels.left; column < pixels.right; ++column) {
                const std::size_t pixel = std::size_t{row} * sums_.width() + column;
                const auto opacity = static_cast<float>(-std::expm1(-opacity_ * sums_.depthAt(pixel)));
                if (opacity > 0.0F)
                    fragments.push_back(
                        {column, row, depth_, opacity, glm::vec3(sums_.shadeAt(pixel) * color_)});
            }
        }
    }

  private:
    HighlightSums sums_;
    glm::dvec3 color_;
    double opacity_, depth_;
};

}  // namespace

void lowerHighlight(const Layer& layer, const Highlight& highlight, const ParticlesStyle& style,
                    const storage::ParticleStep& points, const Bounds& inEye, Lowering& out) {
    FramePlan& plan = out.plan;
    // A slab of an exact picture before the box, so that none of the layer's own points is mixed with them.
    const double nearest = -inEye.max.z, farthest = -inEye.min.z;
    const double depth = std::max(nearest - (farthest - nearest) / 192.0, nearLimit(plan.camera));
    if (!(farthest > depth) || !(highlight.opacity > 0.0)) return;
    const double share = out.quality.pointFraction;
    const double size = highlight.pointSize.value_or(style.pointSize);
    const PointLook look = movingLook({.size = size, .opacity = highlight.opacity}, 1.0,
                                      LessDrawn::of(out.pixels, share, size, points.pointCount()));
    const glm::dmat4 boxToEye = plan.camera.worldToEye() * layer.transform * plotToLayer();
    DepthMoments moments(nearest, farthest);
    forDrawn(points, boxToEye, share, moments);
    HighlightSums sums(plan, look, moments.shaded());
    forDrawn(points, boxToEye, share, sums);
    if (!sums.any()) return;
    // What else has this very depth, as where all begins to be seen, lies behind them, since they are points.
    const double before = std::nextafter(depth, -std::numeric_limits<double>::infinity());
    plan.surfaces.push_back(
        std::make_shared<const HighlightFragments>(std::move(sums), highlight.color, layer.opacity, before));
    out.addDots(depth, depth);
}

}  // namespace mote::render
