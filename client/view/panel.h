// SPDX-License-Identifier: GPL-3.0-or-later
//
// The panel: the side of the window with every control. It edits the model and returns what only the viewer
// can do. Main thread, between Window::beginFrame and drawFrame.
#pragma once

#include <cstdint>
#include <optional>

#include "client/view/numbers/numbers_editor.h"
#include "client/view/panel_widgets.h"
#include "client/view/server_state.h"
#include "client/view/view_files.h"
#include "client/view/view_model.h"

namespace mote::client {

/// When the next step of a series is shown: at a chosen rate, but not before the one of now was
/// seen, so that a slow server leaves none out. A value that knows no clock.
class Playback {
  public:
    bool playing = false;
    float stepsPerSecond = 10.0F;

    /// The step to show at `now` seconds; after the last comes the first. `seen`: a picture of `step` is on
    /// the screen.
    std::optional<std::uint32_t> next(double now, std::uint32_t step, int steps, bool seen) {
        if (!playing || !seen || steps < 2 || now < last_ + 1.0 / stepsPerSecond) return std::nullopt;
        last_ = now;
        return (step + 1) % static_cast<std::uint32_t>(steps);
    }

  private:
    double last_ = 0.0;  // seconds; when a step was last shown
};

inline constexpr float panelWidth = 340.0F;  ///< screen coordinates at a content scale of 1

/// Draws the panel at the right edge of the window, whose content scale is `scale`.
PanelActions drawPanel(ViewModel& model, Playback& playback, NumbersEditor& numbers, ViewFiles& files,
                       const ServerState& server, float scale);

}  // namespace mote::client
