// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridTransfer: the transfer functions of a hybrid layer, with what its style leaves out taken from its
// step: value to extinction and colour. Part of the picture's definition (docs/PICTURE.md), shared by devices
// and reference. A value; safe on any number of threads.
#pragma once

#include <glm/vec3.hpp>

#include "protocol/scene/hybrid_style.h"
#include "server/render/layers/hybrid/hybrid_step.h"

namespace mote::render {

/// Where a style has none: the first preset that suits the values (protocol/scene/curve_presets.h), which is
/// what a viewer begins with.
Curve defaultOpacity(const HybridStep& step);

/// What the step has, where the style leaves it open.
HybridRepresentation resolved(HybridRepresentation asked, const HybridStep& step);

class HybridTransfer {
  public:
    HybridTransfer(const HybridStyle& style, const HybridStep& step);

    /// Per unit length of layer space.
    double extinction(double value) const;
    /// Linear RGB, before light.
    glm::dvec3 color(double value) const;
    /// Outside of which neither changes, in the source's unit.
    const ValueRange& span() const { return span_; }
    const Curve& opacity() const { return opacity_; }

    bool operator==(const HybridTransfer&) const = default;

  private:
    Curve opacity_;
    std::vector<glm::dvec3> colors_;
    ColorMap colorMap_;
    ValueRange colorRange_;
    ValueRange span_;
    double opacityLength_;  // layer units
};

}  // namespace mote::render
