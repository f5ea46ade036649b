// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/hybrid/point_looks.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

namespace mote::render {

double pointSpacing(const HybridStep& step) {
    const glm::dvec3 size(step.points->size);
    return std::cbrt(std::abs(glm::determinant(glm::dmat3(step.boxToLayer))) / (size.x * size.y * size.z));
}

PointLooks::PointLooks(const HybridStep& step, const HybridTransfer& transfer, double strength)
    : opacities_(codes * codes), colors_{} {
    const double spacing = pointSpacing(step);
    for (std::size_t value = 0; value < codes; ++value) {
        const double v = std::lerp(step.range.low, step.range.high, static_cast<double>(value) / 255.0);
        colors_[value] = glm::vec3(transfer.color(v));
        const double whole = transfer.extinction(v);
        if (!(whole > 0.0)) continue;
        for (std::size_t error = 0; error < codes; ++error) {
            const double e = (static_cast<double>(error) - 128.0) * step.points->errorStep;
            const double lack = std::max(0.0, whole - transfer.extinction(v - e));
            opacities_[value | error * codes] = static_cast<float>(-std::expm1(-strength * lack * spacing));
        }
    }
}

const PointLooks& KeptPointLooks::of(const HybridPlan& plan) {
    const double strength = plan.pointStrength();
    if (!key_ || key_->step.lock() != plan.step || key_->transfer != plan.transfer ||
        key_->strength != strength) {
        looks_.emplace(*plan.step, plan.transfer, strength);
        key_ = Key{plan.step, plan.transfer, strength};
    }
    return *looks_;
}

}  // namespace mote::render
