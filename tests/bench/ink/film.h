// SPDX-License-Identifier: GPL-3.0-or-later
//
// How a film of drawings flickers: what of its ink comes and goes where no motion explains it. A value.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "server/render/ink/drawing.h"
#include "server/render/plan/frame_plan.h"

namespace mote::bench {

/// The share of each pixel that ink covers.
render::Raster<float> coverOf(const render::Strokes& strokes, const render::FramePlan& plan);

/// What a part of a stroke is: a line beside nothing, another of a kind, or a hatch.
enum class InkPart : std::uint8_t { outer, silhouette, border, crease, hatch };

/// Strokes that are on the surface, each point with what begins there.
struct FilmStrokes {
    render::Strokes strokes;
    std::vector<InkPart> parts;  ///< of points
};

/// Strokes go with the surface that they are drawn on, and where that is seen in both of two pictures, ink of
/// the one is compared with that of the other, as the eye sees it.
class Film {
  public:
    static constexpr std::array partNames{"outer contours", "silhouettes", "borders", "creases", "hatches"};

    /// What one kind of ink does from picture to picture, alone.
    struct Part {
        double changed = 0.0, inked = 0.0;
    };

    /// The next picture. `memory`: as drawInk left it.
    void show(const render::InkScene& scene, const render::Drawing& drawing, const render::InkMemory& memory,
              const render::FramePlan& plan);
    /// As a share of the ink.
    double flicker() const { return changed_ / inked_; }
    /// The same of ink that nothing hides within a pixel, in neither picture: without what goes behind
    /// something, or comes from behind it, which motion explains.
    double flickerInFront() const { return changedInFront_ / inkedInFront_; }
    /// How much of the ink that is.
    double inFront() const { return inkedInFront_ / inked_; }
    /// Ink of the last picture, pixels.
    double ink() const { return ink_; }
    const std::array<Part, 5>& parts() const { return parts_; }
    /// Called with what each picture's ink was and is, moved to where it is, where that is compared.
    std::function<void(const render::Raster<float>& was, const render::Raster<float>& is)> compared;

  private:
    FilmStrokes before_;
    render::Raster<float> depth_;
    render::InkCamera camera_;
    double changed_ = 0.0, inked_ = 0.0, ink_ = 0.0;
    double changedInFront_ = 0.0, inkedInFront_ = 0.0;
    std::array<Part, 5> parts_{};
};

}  // namespace mote::bench
