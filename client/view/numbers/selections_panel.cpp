// SPDX-License-Identifier: GPL-3.0-or-later
//
// The list of selections.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "client/view/numbers/numbers_panel.h"
#include "client/view/numbers/statistic_rows.h"

namespace mote::client {
namespace {

bool toggle(const char* label, bool on) {
    if (on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
    const bool pressed = ImGui::Button(label);
    if (on) ImGui::PopStyleColor();
    return pressed;
}

void takeNew(const NumbersPanel& panel, proto::Selection selection, const char* wish) {
    if (panel.controls.follow && panel.manifest.ids()) selection.set_step(panel.step);
    panel.controls.say(panel.model.take(selection, panel.controls.combine, wish));
    panel.actions.viewChanged = true;
}

void drawNewConditions(const NumbersPanel& panel) {
    if (!ImGui::BeginPopup("condition")) return;
    proto::Selection selection;
    if (ImGui::MenuItem("the halo: low log density")) {
        selection.mutable_density()->set_max(0.4);
        takeNew(panel, selection, "halo");
    }
    if (ImGui::MenuItem("the outermost 1% in x")) {
        selection.mutable_outermost()->set_plane("x");
        selection.mutable_outermost()->set_share(0.01);
        takeNew(panel, selection, "outermost");
    }
    if (!panel.quantities.empty() && ImGui::MenuItem("a range of a column")) {
        const auto& first = panel.quantities.front();
        auto& range = *selection.add_ranges();
        range.set_column(first.name);
        if (first.range) range.set_min(first.range->low);
        if (first.range) range.set_max(first.range->high);
        takeNew(panel, selection, "range");
    }
    const auto* chosen = panel.model.chosenSelection();
    if (chosen != nullptr && ImGui::MenuItem(fmt::format("all but \"{}\"", chosen->name()).c_str())) {
        *selection.mutable_negated() = reference(chosen->name());
        panel.controls.say(panel.model.take(selection, Combine::fresh, "not " + chosen->name()));
        panel.actions.viewChanged = true;
    }
    ImGui::EndPopup();
}

void drawMaking(const NumbersPanel& panel) {
    auto& controls = panel.controls;
    if (toggle("Lasso (L)", controls.tool.kind() == PictureTool::Kind::lasso))
        controls.tool.toggle(PictureTool::Kind::lasso);
    ImGui::SameLine();
    if (toggle("Histogram (H)", controls.histogramShown)) controls.histogramShown = !controls.histogramShown;
    ImGui::SameLine();
    if (ImGui::Button("+ ...")) ImGui::OpenPopup("condition");
    drawNewConditions(panel);
    int how = static_cast<int>(controls.combine);
    for (const auto& [label, value] : {std::pair{"new", 0}, {"and", 1}, {"or", 2}, {"not", 3}}) {
        if (value > 0) ImGui::SameLine();
        ImGui::RadioButton(label, &how, value);
    }
    controls.combine = static_cast<Combine>(how);
    if (!panel.manifest.ids()) return dim("The run has no ids: a selection is made in each step anew.");
    ImGui::Checkbox("keep its particles through all steps", &controls.follow);
}

/// A row: shown as highlight, shown alone, its name.
void drawRow(const NumbersPanel& panel, std::size_t index) {
    auto& model = panel.model;
    const std::string name = model.selections()[static_cast<int>(index)].name();
    ImGui::PushID(static_cast<int>(index));
    bool lit = model.highlighted() == name, alone = model.alone() == name;
    if (ImGui::Checkbox("##lit", &lit)) {
        model.highlight(lit ? name : "");
        panel.actions.viewChanged = true;
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("highlight it in the picture");
    ImGui::SameLine();
    if (ImGui::Checkbox("##alone", &alone)) {
        model.showAlone(alone ? name : "");
        panel.actions.viewChanged = true;
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("show it alone, as if it were the whole run");
    ImGui::SameLine();
    if (ImGui::Selectable(fmt::format("{}##name", name).c_str(), model.chosen() == index))
        model.choose(index);
    ImGui::PopID();
}

/// How much of the step it is, once that is known.
void drawShare(const NumbersPanel& panel) {
    const auto selected = panel.data.selected();
    const int steps = panel.manifest.steps_size();
    if (!selected.value || selected.value->step >= static_cast<std::uint32_t>(steps)) return;
    const auto& names = selected.value->names;
    const auto found = std::ranges::find(names, "n_particle");
    if (found == names.end()) return;
    const double count = selected.value->values[static_cast<std::size_t>(found - names.begin())];
    const auto all =
        static_cast<double>(panel.manifest.steps(static_cast<int>(selected.value->step)).particles());
    if (!(all > 0.0) || !std::isfinite(count)) return;
    text(fmt::format("{}, {:.3g}% of step {}", metric(count, "particles"), 100.0 * count / all,
                     selected.value->step));
}

void drawLook(const NumbersPanel& panel) {
    auto& model = panel.model;
    if (model.highlighted().empty()) return;
    colorBox(panel.actions, "highlight", model.highlightColor);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(90.0F * panel.scale);
    slider(panel.actions, "##size", model.highlightSize, 0.0F, 8.0F,
           model.highlightSize > 0.0F ? "%.1f pixels" : "layer's size");
    ImGui::SetNextItemWidth(90.0F * panel.scale);
    logSlider(panel.actions, "opacity of a point", model.highlightOpacity, 0.001F, 1.0F, "%.3f");
}

}  // namespace

void drawSelections(const NumbersPanel& panel) {
    if (!section("Selections")) return;
    drawMaking(panel);
    if (!panel.controls.message.empty()) dim(panel.controls.message);
    auto& model = panel.model;
    if (model.selections().empty())
        return dim("None yet: draw a lasso on the picture, or a polygon in a histogram.");
    for (int i = 0; i < model.selections().size(); ++i) drawRow(panel, static_cast<std::size_t>(i));
    drawLook(panel);
    if (const auto* chosen = model.chosenSelection()) {
        const auto copy = *chosen;  // what is drawn edits it
        drawShare(panel);
        drawConditions(panel, copy);
    }
}

}  // namespace mote::client
