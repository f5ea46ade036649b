// SPDX-License-Identifier: GPL-3.0-or-later
//
// CurveEditor: one transfer function as a widget, with the histogram of densities behind it. Drag a knot;
// click on the curve to add one; right-click a knot to remove it. Main thread, inside a Dear ImGui window.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "client/view/transfer_functions.h"
#include "protocol/scene/color_map.h"

namespace mote::client {

struct CurveEditorLook {
    TransferFunctions::Which which;
    std::span<const std::uint64_t> histogram;  ///< particles by scaled log density, even bins over [0, 1]
    std::optional<ColorMap> colorMap;          ///< drawn as a strip below
    float height;                              ///< pixels
};

/// Draws the widget over the width that is left; true where the curve was changed.
bool curveEditor(const char* id, TransferFunctions& functions, const CurveEditorLook& look);

}  // namespace mote::client
