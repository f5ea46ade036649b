// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/depth_spans.h"

#include <cmath>
#include <glm/common.hpp>

namespace mote::render {

DepthSpans::DepthSpans(const View& view)
    : view_(view),
      columns_(static_cast<std::size_t>(std::ceil(view.size.x / edge))),
      rows_(static_cast<std::size_t>(std::ceil(view.size.y / edge))),
      spans_(columns_ * rows_) {}

void DepthSpans::add(const std::array<glm::dvec3, 8>& corners) {
    constexpr double margin = 1.0 / 64.0;  // pixels, for what is rounded
    DepthSpan span;
    glm::dvec2 least(std::numeric_limits<double>::infinity()), most(-least);
    for (const auto& corner : corners) {
        const double depth = -corner.z;
        span.add({depth, depth});
        const glm::dvec2 window = glm::dvec2(corner) / (view_.perspective ? depth : 1.0);
        const glm::dvec2 at(0.5 * view_.size.x + window.x * view_.pixels,
                            0.5 * view_.size.y - window.y * view_.pixels);
        least = glm::min(least, at);
        most = glm::max(most, at);
    }
    if (!(span.far >= view_.nearest)) return;
    if (view_.perspective && span.near < view_.nearest) {  // it is around the eye, or beside it
        least = glm::dvec2(0.0);
        most = view_.size;
    }
    least -= margin;
    most += margin;
    if (!(most.x > 0.0 && most.y > 0.0 && least.x < view_.size.x && least.y < view_.size.y)) return;
    const std::size_t left = tileOf(least.x, columns_), right = tileOf(most.x, columns_),
                      bottom = tileOf(most.y, rows_);
    for (std::size_t row = tileOf(least.y, rows_); row <= bottom; ++row) {
        for (std::size_t column = left; column <= right; ++column) spans_[row * columns_ + column].add(span);
    }
}

void DepthSpans::add(const DepthSpans& other) {
    for (std::size_t i = 0; i < spans_.size(); ++i) spans_[i].add(other.spans_[i]);
}

}  // namespace mote::render
