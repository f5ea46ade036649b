// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/numbers_editor.h"

#include <imgui.h>

#include "client/view/numbers/numbers_panel.h"
#include "client/view/view_model.h"

namespace mote::client {
namespace {

constexpr const char* noColumns =
    "This dataset was made without columns: make it again from its source (mote-prep particles) to have its "
    "numbers.";

double aspectOf(const NumbersArea& area) {
    return static_cast<double>(area.columns) / area.rows;
}

}  // namespace

void NumbersEditor::drawPanel(ViewModel& model, const proto::Manifest& manifest, float scale,
                              PanelActions& actions) {
    const auto& particles = manifest.particles();
    const auto quantities = quantitiesOf(particles);
    const NumbersPanel panel{model.numbers, controls_,    data_, particles,
                             quantities,    model.step(), scale, actions};
    if (quantities.empty()) dim(noColumns);
    drawSelections(panel);
    if (const auto step = drawStatistics(panel)) {
        model.setStep(*step);
        actions.viewChanged = true;
    }
    if (!quantities.empty()) drawColorBy(panel);
    drawPicked(panel);
    drawAnnotations(panel);
}

void NumbersEditor::drawOver(ViewModel& model, const proto::Manifest* manifest, const NumbersArea& area,
                             float scale, PanelActions& actions, bool moving) {
    const bool particles = manifest != nullptr && model.kind() == proto::Layer::kParticles;
    const auto quantities = particles ? quantitiesOf(manifest->particles()) : std::vector<Quantity>();
    ids_ = particles && manifest->particles().ids();
    if (!particles) controls_.tool.setKind(PictureTool::Kind::none);
    const bool histogram = controls_.histogramShown && quantities.size() >= 2;
    if (histogram) {
        const NumbersPanel panel{model.numbers, controls_,    data_, manifest->particles(),
                                 quantities,    model.step(), scale, actions};
        const auto polygon = window_.draw(panel, area.width, area.height);
        const auto& columns = controls_.histogram.columns;
        if (!polygon.empty())
            takeGesture(model, polygonIn(columns[0], columns[1], polygon), "polygon", actions);
    }
    if (!particles) return;
    ask(model, histogram, open && !quantities.empty() && manifest->particles().statistic_names().empty(),
        moving);
    drawTool(area);
}

void NumbersEditor::ask(const ViewModel& model, bool histogram, bool whole, bool moving) {
    NumbersWanted wanted{model.dataset(), model.step()};
    wanted.whole = whole;
    wanted.moving = moving;
    const auto selection = model.numbers.chosenWhole();
    if (open) {
        wanted.selection = selection;
        wanted.series = controls_.series;
    }
    if (histogram) {
        wanted.histogram = controls_.histogram.query();
        wanted.histogramOfSelection = controls_.histogram.ofSelection && selection.has_value();
        if (wanted.histogramOfSelection) wanted.selection = selection;
    }
    data_.want(wanted);
}

bool NumbersEditor::takeMouse(ViewModel& model, const NumbersArea& area, PanelActions& actions) {
    if (model.kind() != proto::Layer::kParticles) return false;
    const ImGuiIO& io = ImGui::GetIO();
    PictureTool::Mouse mouse{{io.MousePos.x / area.width, io.MousePos.y / area.height},
                             {1.0 / area.width, 1.0 / area.height}};
    mouse.held = ImGui::IsMouseDown(ImGuiMouseButton_Left);
    mouse.pressed = ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse;
    mouse.picks = mouse.held && io.KeyCtrl && controls_.tool.kind() == PictureTool::Kind::none;
    // The right button and the wheel stay the camera's.
    const bool mine = controls_.tool.takes(mouse) && (mouse.held || controls_.tool.drawing());
    if (!mine) return false;
    const auto done = controls_.tool.move(mouse);
    if (!done.lasso.empty()) {
        const auto view = model.view(area.columns, area.rows);
        const double aspect = aspectOf(area);
        takeGesture(model, lassoOn(model.camera(aspect), aspect, view.layers(0), done.lasso), "lasso",
                    actions);
        open = true;
    }
    if (done.pick) {
        proto::PickQuery place;
        *place.mutable_view() = model.view(area.columns, area.rows);
        place.set_x(done.pick->x * area.columns);
        place.set_y(done.pick->y * area.rows);
        data_.pick(place);
        open = true;
    }
    return true;
}

void NumbersEditor::takeGesture(ViewModel& model, proto::Selection gesture, const char* wish,
                                PanelActions& actions) {
    if (controls_.follow && ids_) gesture.set_step(model.step());
    controls_.say(model.numbers.take(gesture, controls_.combine, wish));
    actions.viewChanged = true;
}

void NumbersEditor::drawTool(const NumbersArea& area) const {
    const auto kind = controls_.tool.kind();
    if (kind == PictureTool::Kind::none) return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const auto* said = kind == PictureTool::Kind::lasso
                           ? "Lasso: draw a line around particles (L or Esc ends)"
                           : "Pick: click on a point (P or Esc ends)";
    const ImVec2 size = ImGui::CalcTextSize(said);
    const ImVec2 at{0.5F * (area.width - size.x), 14.0F};
    draw.AddRectFilled({at.x - 12.0F, at.y - 6.0F}, {at.x + size.x + 12.0F, at.y + size.y + 6.0F},
                       IM_COL32(20, 24, 32, 220), 8.0F);
    draw.AddText(at, IM_COL32(235, 240, 250, 255), said);
    const auto& line = controls_.tool.line();
    for (const auto& place : line)
        draw.PathLineTo(
            {static_cast<float>(place.x) * area.width, static_cast<float>(place.y) * area.height});
    draw.PathStroke(IM_COL32(255, 255, 255, 235), ImDrawFlags_Closed, 2.0F);
}

}  // namespace mote::client
