// SPDX-License-Identifier: GPL-3.0-or-later
//
// How a film of drawings flickers: what of its ink comes and goes where no motion explains it. A value.
#pragma once

#include <vector>

#include "server/render/ink/drawing.h"
#include "server/render/plan/frame_plan.h"

namespace mote::bench {

/// The share of each pixel that ink covers.
render::Raster<float> coverOf(const render::Strokes& strokes, const render::FramePlan& plan);

/// Strokes go with the surface that they are drawn on, and where that is seen in both of two pictures, ink of
/// the one is compared with that of the other, as the eye sees it.
class Film {
  public:
    /// The next picture. `memory`: as drawInk left it.
    void show(const render::InkScene& scene, const render::Drawing& drawing, const render::InkMemory& memory,
              const render::FramePlan& plan);
    /// As a share of the ink.
    double flicker() const { return changed_ / inked_; }

  private:
    render::Strokes strokes_;
    render::Raster<float> depth_;
    render::InkCamera camera_;
    double changed_ = 0.0, inked_ = 0.0;
};

}  // namespace mote::bench
