// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/image_editor.h"

#include <fmt/format.h>

#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"

namespace mote::client {

void ImageEditor::drawFacts(const LayerPanel& panel) {
    const auto& image = panel.server.shown->manifest().image();
    dim(fmt::format("{} x {} pixels, behind everything", image.width(), image.height()));
}

void ImageEditor::draw(const LayerPanel& panel) {
    backgroundBox(panel.actions, panel.background);
}

}  // namespace mote::client
