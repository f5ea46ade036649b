// SPDX-License-Identifier: GPL-3.0-or-later
//
// Panel: the side of the window with every control. It edits the model and returns what only the viewer can
// do. Main thread, between Window::beginFrame and drawFrame.
#pragma once

#include <optional>
#include <string>

#include "client/view/playback.h"
#include "client/view/replot.h"
#include "client/view/server_state.h"
#include "client/view/view_model.h"

namespace mote::client {

/// What the user asked for in this frame.
struct PanelActions {
    bool viewChanged = false;  ///< the model was edited
    bool editing = false;      ///< and a control is still held
    bool saveView = false;
    bool reconnect = false;
    std::optional<std::string> openDataset;  ///< a name of the catalogue
    std::optional<AxisNames> plot;           ///< other axes of the shown run
    std::optional<std::string> cancelJob;    ///< an id
};

class Panel {
  public:
    static constexpr float width = 340.0F;  ///< screen coordinates at a content scale of 1

    /// Draws the panel at the right edge of the window.
    PanelActions draw(ViewModel& model, Playback& playback, const ServerState& server, float scale);

  private:
    void drawDataset(ViewModel& model, Playback& playback, const ServerState& server, PanelActions& actions);
    static void drawSteps(ViewModel& model, Playback& playback, int steps, PanelActions& actions);
    void drawAxes(const ServerState& server, PanelActions& actions);
    static void drawCurves(ViewModel& model, const ServerState& server, PanelActions& actions, float scale);
    static void drawStippleLayer(ViewModel& model, const ServerState& server, PanelActions& actions);
    static void drawVolumeLayer(ViewModel& model, const ServerState& server, PanelActions& actions,
                                float scale);
    static void drawPoints(ViewModel& model, PanelActions& actions);
    static void drawCamera(ViewModel& model, PanelActions& actions);
    static void drawJobs(const ServerState& server, PanelActions& actions);
    static void drawConnection(const ServerState& server, PanelActions& actions);

    AxisNames axes_;             // chosen in the lists
    std::string axesOfDataset_;  // the dataset that axes_ was last taken from
};

}  // namespace mote::client
