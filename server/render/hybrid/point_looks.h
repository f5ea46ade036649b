// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointLooks: what the points of a hybrid volume look like by their codes, for one transfer function
// (docs/PICTURE.md, "Hybrid volumes"). Shared by both devices. A value; safe on any number of threads.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "server/render/hybrid/hybrid_plan.h"

namespace mote::render {

/// The edge of the cube that a point stands for, layer units. The step must have points.
double pointSpacing(const HybridStep& step);

class PointLooks {
  public:
    static constexpr std::size_t codes = 256;

    /// `strength`: HybridPlan's. The step must have points.
    PointLooks(const HybridStep& step, const HybridTransfer& transfer, double strength);

    /// What the low volume lacks, before style and footprint; 0 to 1.
    float opacity(const HybridPoint& point) const { return opacities_[point.value | point.error * codes]; }
    /// Linear RGB, before light.
    const glm::vec3& color(const HybridPoint& point) const { return colors_[point.value]; }

    /// By value | error << 8.
    const std::vector<float>& opacities() const { return opacities_; }
    const std::array<glm::vec3, codes>& colors() const { return colors_; }

  private:
    std::vector<float> opacities_;
    std::array<glm::vec3, codes> colors_;
};

/// The looks of a layer, kept from picture to picture: making them takes milliseconds. It holds no step
/// alive. Owned by who draws; one thread.
class KeptPointLooks {
  public:
    const PointLooks& of(const HybridPlan& plan);

  private:
    struct Key {
        std::weak_ptr<const HybridStep> step;
        HybridTransfer transfer;
        double strength;
    };
    std::optional<Key> key_;
    std::optional<PointLooks> looks_;
};

}  // namespace mote::render
