// SPDX-License-Identifier: GPL-3.0-or-later
//
// The parts of the panel that show and edit the numbers of a particle layer. Main thread, within the panel's
// window.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/view/numbers/histogram_view.h"
#include "client/view/numbers/numbers_data.h"
#include "client/view/numbers/numbers_model.h"
#include "client/view/numbers/quantities.h"
#include "client/view/numbers/selection_edits.h"
#include "client/view/panel_widgets.h"
#include "protocol/base/error.h"

namespace mote::client {

/// What the panel of numbers remembers that is no part of the view. A value; main thread.
struct NumbersControls {
    PictureTool tool;
    Combine combine = Combine::fresh;
    bool follow = true;  ///< what is made now holds its particles in all steps, where they have ids
    HistogramView histogram;
    bool histogramShown = false;
    bool allStatistics = false;
    std::string series = "norm_emit_x";  ///< the statistic that is plotted
    std::string message;                 ///< the last failure, one sentence
    std::array<char, 257> typedName{};   ///< of the chosen selection
    std::string typedFor;                ///< the name that it was typed for

    void say(const Status& status) { message = status.ok() ? std::string() : status.error().toString(); }
};

/// What the parts are drawn with.
struct NumbersPanel {
    NumbersModel& model;
    NumbersControls& controls;
    NumbersData& data;
    const proto::ParticlesManifest& manifest;
    const std::vector<Quantity>& quantities;
    std::uint32_t step;  ///< that is shown
    float scale;         ///< pixels to a screen coordinate
    PanelActions& actions;
};

/// What a picture says beside what it shows, of any view.
void drawAnnotations(PanelActions& actions, proto::Annotations& annotations);
/// The list of selections, and how the next is made.
void drawSelections(const NumbersPanel& panel);
/// The conditions of the chosen one.
void drawConditions(const NumbersPanel& panel, const proto::NamedSelection& chosen);
/// A table of statistics and one of them over the steps; the step that the user goes to.
std::optional<std::uint32_t> drawStatistics(const NumbersPanel& panel);
void drawColorBy(const NumbersPanel& panel);
void drawPicked(const NumbersPanel& panel);

/// The selection that the panel edits is now this one; a refusal is said.
void edit(const NumbersPanel& panel, const proto::Selection& selection);

}  // namespace mote::client
