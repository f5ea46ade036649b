// SPDX-License-Identifier: GPL-3.0-or-later
//
// HistogramWindow: a histogram of two columns at full data, in a window over the picture: the wheel zooms, a
// line of clicks around a region makes a selection of it. Main thread, with the window's context current.
#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <vector>

#include "client/view/numbers/histogram_picture.h"
#include "client/view/numbers/numbers_panel.h"
#include "client/view/numbers/plot_frame.h"
#include "client/view/window.h"

namespace mote::client {

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

}  // namespace mote::client
