// SPDX-License-Identifier: GPL-3.0-or-later
//
// NumbersEditor: the numbers behind the viewer's picture: its part of the panel, the histogram's window, the
// tools on the picture, and the questions that they need answered. Owned by the viewer; main thread, with the
// window's context current.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/view/numbers/histogram_view.h"
#include "client/view/numbers/numbers_data.h"
#include "client/view/numbers/numbers_model.h"
#include "client/view/numbers/numbers_panel.h"
#include "client/view/numbers/plot_frame.h"
#include "client/view/over_picture.h"
#include "client/view/panel_widgets.h"
#include "client/view/window.h"

namespace mote::client {

/// A histogram of two columns at full data, in a window over the picture: the wheel zooms, a
/// line of clicks around a region makes a selection of it. Main thread, with the window's context current.
class HistogramWindow {
  public:
    /// Draws it over a picture of these pixels; a closed polygon in its two columns' units, once there is
    /// one.
    std::vector<glm::dvec2> draw(const NumbersPanel& panel, float width, float height);

  private:
    void drawControls(const NumbersPanel& panel);
    std::vector<glm::dvec2> drawPlot(const NumbersPanel& panel, const StepHistogram& histogram);
    void upload(const StepHistogram& histogram, const HistogramView& view);
    void drawPolygons(const NumbersPanel& panel, const PlotFrame& frame, bool hovered) const;
    void zoom(const NumbersPanel& panel, const PlotFrame& frame) const;
    std::vector<glm::dvec2> takeClicks(const PlotFrame& frame, bool hovered);

    std::unique_ptr<PictureTexture> texture_;
    std::vector<double> shownCounts_;  // that the texture is of
    std::string shownLook_;
    std::array<std::string, 2> cornersOf_;  // columns
    std::vector<glm::dvec2> corners_;       // of the polygon under way
};

class ViewModel;
struct ServerState;

class NumbersEditor {
  public:
    explicit NumbersEditor(const QueryLine& line) : data_(line) {}

    /// The tab's content. The view model's layer is of particles.
    void drawPanel(ViewModel& model, const proto::Manifest& manifest, float scale, PanelActions& actions);
    /// The windows over the picture and the tools' traces on it, and the questions that are due.
    void drawOver(ViewModel& model, const proto::Manifest* manifest, const PictureArea& area,
                  PanelActions& actions, bool moving);
    /// True if the mouse is a tool's and not the camera's.
    bool takeMouse(ViewModel& model, const proto::Manifest* manifest, const PictureArea& area,
                   PanelActions& actions);

    void forget() { data_.forget(); }
    PictureTool& tool() { return controls_.tool; }
    void toggleHistogram() { controls_.histogramShown = !controls_.histogramShown; }
    bool open = false;  ///< the panel shows them

  private:
    void takeGesture(ViewModel& model, proto::Selection gesture, const char* wish, PanelActions& actions);
    void ask(const ViewModel& model, bool histogram, bool whole, bool moving);
    void drawTool(const PictureArea& area) const;

    NumbersControls controls_;
    NumbersData data_;
    HistogramWindow window_;
    bool ids_ = false;  // the dataset has them
};

}  // namespace mote::client
