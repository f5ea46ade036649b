// SPDX-License-Identifier: GPL-3.0-or-later
//
// What points cover of pixels; and which are so few that each is drawn where it stands, as a dot is: in exact
// order with volumes, dots and the points of other layers, not mixed within a slab (docs/PICTURE.md). Values
// and pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "server/render/plan/frame_plan.h"
#include "server/render/plan/screen_dots.h"

namespace mote::render {

/// Pixels [left, right) x [top, bottom).
struct PixelBox {
    std::int32_t left, top, right, bottom;
};

/// How much a point of more than one pixel adds to the pixels around it (docs/PICTURE.md, "Points"). Made
/// once a picture.
class DiscFootprint {
  public:
    static constexpr std::uint32_t steps = 1024;  ///< of coverage: opacity to within a thousandth

    /// `size`: diameter in pixels, above 1; `opacity`: of a whole point.
    DiscFootprint(double size, double opacity);

    /// How far it reaches from a point's centre, pixels.
    float reach() const { return reach_; }
    /// The weight of a pixel by its coverage, in steps.
    const std::array<float, steps + 1>& weights() const { return weight_; }
    /// Whether the weight is the coverage, to within a 4096th.
    bool proportional() const { return opacity_ < 1.0F / 512.0F; }
    /// Of a whole point; 0: the weight is the coverage.
    float opacity() const { return opacity_; }
    /// 1 / ln(1 - opacity), where it is not 0.
    float ofLogarithm() const { return ofLogarithm_; }

    /// Calls add(column, row, weight) for each pixel of `box` that a point at (x, y) covers: its optical
    /// depth over that of a whole point, above 0, at most 1.
    template <class Add>
    void spread(float x, float y, const PixelBox& box, Add add) const;

  private:
    float reach_;
    float opacity_, ofLogarithm_;
    std::array<float, steps + 1> weight_;  // by coverage
};

template <class Add>
void DiscFootprint::spread(float x, float y, const PixelBox& box, Add add) const {
    // Pixel i has its centre at i + 1/2.
    const auto first = [this](float at, std::int32_t least) {
        return std::max(static_cast<std::int32_t>(std::floor(at - reach_ + 0.5F)), least);
    };
    const auto end = [this](float at, std::int32_t most) {
        return std::min(static_cast<std::int32_t>(std::ceil(at + reach_ - 0.5F)) + 1, most);
    };
    const std::int32_t left = first(x, box.left), right = end(x, box.right);
    const std::int32_t bottom = end(y, box.bottom);
    for (std::int32_t row = first(y, box.top); row < bottom; ++row) {
        const float dy = static_cast<float>(row) + 0.5F - y;
        for (std::int32_t column = left; column < right; ++column) {
            const float dx = static_cast<float>(column) + 0.5F - x;
            const float coverage = std::clamp(reach_ - std::sqrt(dx * dx + dy * dy), 0.0F, 1.0F);
            // Never negative, and std::lround would be a call for each pixel:
            // NOLINTNEXTLINE(bugprone-incorrect-roundings)
            const float weight = weight_[static_cast<std::uint32_t>(coverage * steps + 0.5F)];
            if (weight > 0.0F) add(column, row, weight);
        }
    }
}

/// Whether each point of a layer is drawn where it stands. The same on all ranks, before points are dealt.
bool standAlone(const FramePlan& plan, const PointsPlan& points);

/// Whether the TileCells of points tell the densities of their leaves, by which they are coloured.
bool shadesCells(const FramePlan& plan, const PointsPlan& points);

/// What a point of a look covers of a pixel, before it is thinned; of one that is lit, what its optical depth
/// is times there. Its reach is 0 where it lies in one pixel alone.
DotFootprint pointFootprint(const PointLook& look);

/// The opacity that is left of a point in a pixel (PointLook::thinned).
inline float thinnedOpacity(float opacity, double thinned) {
    return thinned == 1.0 ? opacity : static_cast<float>(-std::expm1(thinned * std::log1p(-opacity)));
}

}  // namespace mote::render
