// SPDX-License-Identifier: GPL-3.0-or-later
//
// A drawing in pen and ink: from what a scene looks like and its lines to strokes (docs/INK.md): the 2D and
// the final stage of the dissertation's section 2.3. Pure; uses all threads of the calling arena, with the
// same drawing on any number of them.
#pragma once

#include <stop_token>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/ink_line.h"
#include "server/render/ink/ink_memory.h"
#include "server/render/ink/modalities.h"
#include "server/render/plan/stroke.h"

namespace mote::render {

/// The 3D stage's result; lines in pixels of the modalities.
struct InkScene {
    Modalities modalities;
    std::vector<InkLine> lines;
    InkCamera camera;
    bool quick = false;  ///< for a picture in motion: its lines have ranks
    bool field = false;  ///< whether what is seen thins out, so that its border need not be a line
};

struct Drawing {
    Strokes strokes;
    /// What the style shows instead of strokes, 0 to 1 in each colour, linear RGB; or empty.
    Raster<glm::vec3> shown;
    /// Under the strokes: Wash::pigment.
    Raster<float> pigment;
};

/// `pixels`: of the scene, a pixel of the view, in which the style gives lengths. `memory`: of the drawing
/// before, one that is empty, or null; this one stays like that where it can, and is what is remembered then.
/// If `stop` is requested meanwhile the drawing lacks something, and the memory stays.
Drawing drawInk(const InkScene& scene, const InkStyle& style, double pixels, const std::stop_token& stop,
                InkMemory* memory = nullptr);

}  // namespace mote::render
