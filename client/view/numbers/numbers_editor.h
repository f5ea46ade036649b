// SPDX-License-Identifier: GPL-3.0-or-later
//
// NumbersEditor: the numbers behind the viewer's picture: its part of the panel, the histogram's window, the
// tools on the picture, and the questions that they need answered. Owned by the viewer; main thread, with the
// window's context current.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "client/view/numbers/histogram_window.h"
#include "client/view/numbers/numbers_controls.h"
#include "client/view/numbers/numbers_data.h"
#include "client/view/numbers/numbers_model.h"
#include "client/view/panel_widgets.h"

namespace mote::client {

class ViewModel;
struct ServerState;

/// The picture on the screen, from its upper left corner on.
struct NumbersArea {
    float width, height;          // screen coordinates
    std::uint32_t columns, rows;  // pixels of the view
};

class NumbersEditor {
  public:
    explicit NumbersEditor(const QueryLine& line) : data_(line) {}

    /// The tab's content. The view model's layer is of particles.
    void drawPanel(ViewModel& model, const proto::Manifest& manifest, float scale, PanelActions& actions);
    /// The windows over the picture and the tools' traces on it, and the questions that are due.
    void drawOver(ViewModel& model, const proto::Manifest* manifest, const NumbersArea& area, float scale,
                  PanelActions& actions, bool moving);
    /// True where the mouse is a tool's and not the camera's.
    bool takeMouse(ViewModel& model, const NumbersArea& area, PanelActions& actions);

    void forget() { data_.forget(); }
    PictureTool& tool() { return controls_.tool; }
    void toggleHistogram() { controls_.histogramShown = !controls_.histogramShown; }
    bool open = false;  ///< the panel shows them

  private:
    void takeGesture(ViewModel& model, proto::Selection gesture, const char* wish, PanelActions& actions);
    void ask(const ViewModel& model, bool histogram, bool whole, bool moving);
    void drawTool(const NumbersArea& area) const;

    NumbersControls controls_;
    NumbersData data_;
    HistogramWindow window_;
    bool ids_ = false;  // the dataset has them
};

}  // namespace mote::client
