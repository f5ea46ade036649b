// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/hybrid_transfer.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "protocol/scene/curve_presets.h"

namespace mote::render {
namespace {

/// From the least to the greatest knot; a small range where there is but one.
ValueRange knotsOf(const Curve& curve, const ValueRange& all) {
    const double low = curve.knots().front().x, high = curve.knots().back().x;
    return {low, high > low ? high : low + (all.high - all.low) / 256.0};
}

/// With a margin, so that a step at a knot lies inside; of a table's 4095 cells 63 on either side, so that
/// both ends of the range are ends of cells.
ValueRange around(const ValueRange& range) {
    const double margin = (range.high - range.low) / 63.0;
    return {range.low - margin, range.high + margin};
}

}  // namespace

Curve defaultOpacity(const HybridStep& step) {
    const std::vector<std::uint64_t> histogram(step.histogram.begin(), step.histogram.end());
    const auto knots = presetsOf("", step.range, histogram).front().knots;
    return Curve::create(knots, knots.front().x, knots.back().x).value();
}

HybridRepresentation resolved(HybridRepresentation asked, const HybridStep& step) {
    return asked == HybridRepresentation::best ? step.parts : asked;
}

HybridTransfer::HybridTransfer(const HybridStyle& style, const HybridStep& step)
    : opacity_(style.opacity ? *style.opacity : defaultOpacity(step)),
      colors_(style.colors),
      colorMap_(style.colorMap),
      colorRange_(style.colorRange ? *style.colorRange : knotsOf(opacity_, step.range)),
      span_(knotsOf(opacity_, step.range)),
      opacityLength_(HybridStyle::opacityShare * step.longestEdge()) {
    if (colors_.empty())
        span_ = {std::min(span_.low, colorRange_.low), std::max(span_.high, colorRange_.high)};
    span_ = around(span_);
}

double HybridTransfer::extinction(double value) const {
    return -std::log1p(-std::min(opacity_(value), HybridStyle::opacityLimit)) / opacityLength_;
}

glm::dvec3 HybridTransfer::color(double value) const {
    if (colors_.empty()) return colorMap_((value - colorRange_.low) / (colorRange_.high - colorRange_.low));
    const auto& knots = opacity_.knots();
    const auto above = std::upper_bound(knots.begin(), knots.end(), value,
                                        [](double v, const Curve::Knot& knot) { return v < knot.x; });
    if (above == knots.begin()) return colors_.front();
    if (above == knots.end()) return colors_.back();
    const auto i = static_cast<std::size_t>(above - knots.begin());
    return glm::mix(colors_[i - 1], colors_[i], (value - knots[i - 1].x) / (knots[i].x - knots[i - 1].x));
}

}  // namespace mote::render
