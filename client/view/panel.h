// SPDX-License-Identifier: GPL-3.0-or-later
//
// The panel: the side of the window with every control. It edits the model and returns what only the viewer
// can do. Main thread, between Window::beginFrame and drawFrame.
#pragma once

#include <span>

#include "client/view/hand/named_cameras.h"
#include "client/view/layers/handles.h"
#include "client/view/numbers/numbers_editor.h"
#include "client/view/panel_widgets.h"
#include "client/view/panes/links.h"
#include "client/view/server_state.h"
#include "client/view/view_model.h"

namespace mote::client {

/// How many panes the window has, what they do together, and the named cameras of the active one's dataset.
struct PanesShown {
    std::size_t count = 1;
    Links links;
    std::span<const NamedCamera> cameras = {};
};

/// The panel's, until its edge is dragged; screen coordinates at a content scale of 1, as its width always.
inline constexpr float panelWidth = 340.0F, leastPanelWidth = 280.0F;

/// Draws the panel at the right edge of the window, whose content scale is `scale` and which has so many
/// panes: the model is the active one's.
PanelActions drawPanel(ViewModel& model, NumbersEditor& numbers, Handles& handles, const ServerState& server,
                       const PanesShown& panes, float scale, float width = panelWidth);

}  // namespace mote::client
