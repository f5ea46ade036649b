// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/knot_curve.h"

#include <algorithm>
#include <glm/common.hpp>
#include <utility>

#include "client/view/slider_values.h"
#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

std::ptrdiff_t offset(std::size_t index) {
    return static_cast<std::ptrdiff_t>(index);
}

glm::dvec3 toLinear(const KnotCurve::Color& color) {
    return srgbToLinear(toVector(color));
}

/// Where a knot at x belongs: behind those that are not above it.
std::size_t placeOf(const std::vector<Curve::Knot>& knots, double x) {
    const auto above = std::upper_bound(knots.begin(), knots.end(), x,
                                        [](double at, const Curve::Knot& knot) { return at < knot.x; });
    return static_cast<std::size_t>(above - knots.begin());
}

}  // namespace

Interval KnotCurve::axis() const {
    return {std::min(values_.low, knots_.front().x), std::max(values_.high, knots_.back().x)};
}

Interval KnotCurve::extent() const {
    const Interval ends{knots_.front().x, knots_.back().x};
    return ends.low < ends.high ? ends : axis();
}

void KnotCurve::move(std::size_t knot, Curve::Knot to) {
    const double least = knot > 0 ? knots_[knot - 1].x : axis().low;
    const double most = knot + 1 < knots_.size() ? knots_[knot + 1].x : axis().high;
    knots_[knot] = {std::clamp(to.x, least, std::max(least, most)), std::clamp(to.y, 0.0, 1.0)};
}

/// Beyond its last knot a curve is level: a knot at the end of the axis holds it there, so that one between
/// acts where it is.
void KnotCurve::pinEnds(double x) {
    const Interval ends = axis();
    const auto first = knots_.front(), last = knots_.back();
    if (x < first.x && ends.low < first.x) {
        knots_.insert(knots_.begin(), {ends.low, first.y});
        if (!colors_.empty()) colors_.insert(colors_.begin(), Color(colors_.front()));
    }
    if (x > last.x && ends.high > last.x) {
        knots_.push_back({ends.high, last.y});
        if (!colors_.empty()) colors_.push_back(Color(colors_.back()));
    }
}

std::size_t KnotCurve::insert(Curve::Knot at) {
    if (knots_.size() + 1 < mostKnots) pinEnds(at.x);
    const std::size_t index = placeOf(knots_, at.x);
    if (knots_.size() >= mostKnots) return std::min(index, knots_.size() - 1);
    if (!colors_.empty())
        colors_.insert(colors_.begin() + offset(index), toFloats(linearToSrgb(color(at.x))));
    knots_.insert(knots_.begin() + offset(index), at);
    move(index, at);
    return index;
}

void KnotCurve::remove(std::size_t knot) {
    if (knots_.size() < 2) return;
    knots_.erase(knots_.begin() + offset(knot));
    if (!colors_.empty()) colors_.erase(colors_.begin() + offset(knot));
}

void KnotCurve::take(std::vector<Curve::Knot> knots, std::vector<Color> colors) {
    knots_ = std::move(knots);
    colors_ = std::move(colors);
    if (knots_.empty()) knots_.push_back({0.0, 0.0});
    chosen_ = 0;
}

KnotCurve::Color* KnotCurve::chosenColor() {
    return colors_.empty() ? nullptr : &colors_[std::min(chosen_, colors_.size() - 1)];
}

glm::dvec3 KnotCurve::color(double value) const {
    if (colors_.empty()) return glm::dvec3(0.0);
    const std::size_t above = placeOf(knots_, value);
    if (above == 0) return toLinear(colors_.front());
    if (above == knots_.size()) return toLinear(colors_.back());
    const auto &low = knots_[above - 1], &high = knots_[above];
    return glm::mix(toLinear(colors_[above - 1]), toLinear(colors_[above]),
                    (value - low.x) / (high.x - low.x));
}

}  // namespace mote::client
