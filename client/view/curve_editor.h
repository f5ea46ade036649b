// SPDX-License-Identifier: GPL-3.0-or-later
//
// CurveEditor: one transfer function as a widget, with a histogram behind it. Drag a knot; click on the curve
// to add one; right-click a knot to remove it. Main thread, inside a Dear ImGui window.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>

#include "client/view/knot_curve.h"

namespace mote::client {

struct CurveEditorLook {
    const char* xName;
    const char* yName;
    bool rootAxis;                                  ///< y is spread by its square root: opacities
    float height;                                   ///< pixels
    Interval axis = {};                             ///< of x
    std::span<const std::uint64_t> histogram = {};  ///< even bins over histogramRange
    Interval histogramRange = {};
    std::function<glm::dvec3(double)> color = {};  ///< of x, linear RGB, drawn as a strip below
};

/// Draws the widget over the width that is left; true where the curve was changed.
bool curveEditor(const char* id, EditedCurve& curve, const CurveEditorLook& look);

}  // namespace mote::client
