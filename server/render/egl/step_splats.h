// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepSplats: the points of a step of a hybrid volume in the device's memory, and what a transfer function
// makes of each value and error. Owned by the device's ResidentHybridSteps; used while its context is
// current.
#pragma once

#include <cstdint>
#include <optional>

#include "server/render/egl/gl_objects.h"
#include "server/render/hybrid/hybrid_plan.h"

namespace mote::render {

class StepSplats {
  public:
    /// The step must have points. Throws DeviceError, also where the device cannot hold them.
    explicit StepSplats(const HybridStep& step);

    /// x | y << 16, z | value << 16 | error << 24, normal.
    GLuint points() const { return pointsTexture_.get(); }
    std::uint32_t count() const { return count_; }
    std::size_t bytes() const { return points_.bytes() + look_.bytes(); }

    /// What points look like from now on.
    void setLook(const HybridPlan& plan);
    /// As splats.glsl reads it: of value | error << 8 the opacity; of each value red, green and blue before
    /// light; of each normal the shade.
    GLuint look() const { return lookTexture_.get(); }

  private:
    void setTransfer(const HybridPlan& plan);

    GlBuffer points_, look_;
    GlTexture pointsTexture_, lookTexture_;
    std::uint32_t count_;
    std::optional<HybridTransfer> transfer_;  ///< of which the look is
    double strength_ = 0.0;                   ///< likewise
};

}  // namespace mote::render
