// SPDX-License-Identifier: GPL-3.0-or-later
//
// The part of the panel that edits a stipple layer. Main thread, within the panel's window.
#pragma once

#include "client/view/panel.h"
#include "client/view/stipple_controls.h"

namespace mote::client {

/// `images`: the catalogue's image datasets, from which a hierarchy on the plane takes its tones; a surface
/// has none.
void drawStipple(StippleControls& controls, bool plane, const std::vector<std::string_view>& images,
                 PanelActions& actions);

}  // namespace mote::client
