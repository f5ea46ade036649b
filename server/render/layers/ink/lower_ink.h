// SPDX-License-Identifier: GPL-3.0-or-later
//
// An ink layer becomes strokes, or fragments if it shows one of the pictures that its drawing is made from
// (docs/INK.md).
#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <optional>

#include "server/render/ink/ink_memory.h"
#include "server/render/layers/ink/ink_data.h"
#include "server/render/layers/lowering.h"

namespace mote::render {

/// What becomes of a layer: strokes, and what is washed beneath them; or the fragments of a picture. In
/// pixels of the plan.
struct InkDrawing {
    Strokes strokes;
    Fragments fragments;
    std::shared_ptr<const FragmentMaker> wash = {};  ///< or null
    double nearDepth = 0.0, farDepth = 0.0;          ///< between which the data lie, and all fragments
};

/// `plan`: its size, its camera and its background are told, and whether it is exact. `pixels`: of the plan,
/// a pixel of the view. `memory`: as drawInk's. Uses all threads of the calling arena; the same strokes on
/// any number of them. If `stop` is requested meanwhile they lack something. Throws std::bad_alloc.
InkDrawing inkOf(const Layer& layer, const InkStyle& style, const InkData& data, const FramePlan& plan,
                 double pixels, const std::stop_token& stop, InkMemory* memory = nullptr);

/// The depth of what a drawing shows at a place of the plan's picture, in pixels from its upper left corner;
/// nothing where it shows none.
std::optional<double> depthAt(const InkData& data, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, glm::dvec2 at);

/// As inkOf.
void lowerInk(const Layer& layer, const InkStyle& style, const InkData& data, InkMemory* memory,
              Lowering& out);

}  // namespace mote::render
