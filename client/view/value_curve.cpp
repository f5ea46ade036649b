// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/value_curve.h"

#include <algorithm>
#include <glm/common.hpp>
#include <utility>

#include "protocol/scene/srgb.h"

namespace mote::client {
namespace {

std::ptrdiff_t offset(std::size_t index) {
    return static_cast<std::ptrdiff_t>(index);
}

glm::dvec3 toLinear(const ValueCurve::Color& color) {
    return srgbToLinear(glm::dvec3(color[0], color[1], color[2]));
}

}  // namespace

Interval ValueCurve::axis() const {
    return {std::min(values_.low, knots_.front().x), std::max(values_.high, knots_.back().x)};
}

Interval ValueCurve::extent() const {
    const Interval ends{knots_.front().x, knots_.back().x};
    return ends.low < ends.high ? ends : axis();
}

void ValueCurve::move(std::size_t knot, Curve::Knot to) {
    knots_[knot] = heldKnot(knots_, knot, to, axis());
}

std::size_t ValueCurve::insert(Curve::Knot at) {
    const std::size_t index = knotPlace(knots_, at.x);
    if (knots_.size() >= mostKnots) return std::min(index, knots_.size() - 1);
    if (!colors_.empty()) {
        const glm::dvec3 encoded = linearToSrgb(color(at.x));
        colors_.insert(
            colors_.begin() + offset(index),
            {static_cast<float>(encoded.x), static_cast<float>(encoded.y), static_cast<float>(encoded.z)});
    }
    knots_.insert(knots_.begin() + offset(index), at);
    move(index, at);
    return index;
}

void ValueCurve::remove(std::size_t knot) {
    if (knots_.size() < 2) return;
    knots_.erase(knots_.begin() + offset(knot));
    if (!colors_.empty()) colors_.erase(colors_.begin() + offset(knot));
}

void ValueCurve::take(const CurvePreset& preset) {
    knots_ = preset.knots;
    colors_ = preset.colors;
    chosen_ = 0;
}

glm::dvec3 ValueCurve::color(double value) const {
    if (colors_.empty()) return glm::dvec3(0.0);
    const std::size_t above = knotPlace(knots_, value);
    if (above == 0) return toLinear(colors_.front());
    if (above == knots_.size()) return toLinear(colors_.back());
    const auto &low = knots_[above - 1], &high = knots_[above];
    return glm::mix(toLinear(colors_[above - 1]), toLinear(colors_[above]),
                    (value - low.x) / (high.x - low.x));
}

void ValueCurve::write(proto::HybridStyle& style) const {
    style.clear_curve();
    for (std::size_t i = 0; i < knots_.size(); ++i) {
        auto& knot = *style.add_curve();
        knot.set_value(knots_[i].x);
        knot.set_opacity(knots_[i].y);
        if (colors_.empty()) continue;
        for (const float part : colors_[i]) knot.add_color(std::clamp(part, 0.0F, 1.0F));
    }
}

void ValueCurve::read(const proto::HybridStyle& style) {
    knots_.clear();
    colors_.clear();
    for (const auto& knot : style.curve()) {
        knots_.push_back({knot.value(), knot.opacity()});
        if (knot.color_size() == 3) {
            colors_.push_back({static_cast<float>(knot.color(0)), static_cast<float>(knot.color(1)),
                               static_cast<float>(knot.color(2))});
        }
    }
    if (knots_.empty()) knots_.push_back({0.0, 0.0});
    chosen_ = 0;
}

}  // namespace mote::client
