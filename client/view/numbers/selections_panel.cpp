// SPDX-License-Identifier: GPL-3.0-or-later
//
// The list of selections.
#include <fmt/format.h>
#include <imgui.h>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "client/view/numbers/numbers_panel.h"
#include "client/view/numbers/quantities.h"

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

namespace {

// The chosen selection: its name, its step, its conditions.

void drawName(const NumbersPanel& panel, const proto::NamedSelection& chosen) {
    auto& typed = panel.controls.typedName;
    if (panel.controls.typedFor != chosen.name()) {
        panel.controls.typedFor = chosen.name();
        typed.fill('\0');
        std::copy_n(chosen.name().begin(), std::min(chosen.name().size(), typed.size() - 1), typed.begin());
    }
    ImGui::SetNextItemWidth(-80.0F * panel.scale);
    const bool entered =
        ImGui::InputText("##rename", typed.data(), typed.size(), ImGuiInputTextFlags_EnterReturnsTrue);
    if (entered || (ImGui::IsItemDeactivatedAfterEdit() && chosen.name() != typed.data())) {
        panel.controls.say(panel.model.rename(*panel.model.chosen(), typed.data()));
        panel.actions.viewChanged = true;
    }
    ImGui::SameLine();
    if (!ImGui::Button("Delete")) return;
    panel.controls.say(panel.model.remove(*panel.model.chosen()));
    panel.actions.viewChanged = true;
}

/// A number that is dragged between two ends; notes what the hand does.
bool dragNumber(const NumbersPanel& panel, const char* label, double& value, const Interval& ends) {
    const double span = ends.high - ends.low;
    const bool changed =
        ImGui::DragScalar(label, ImGuiDataType_Double, &value, static_cast<float>(span / 400.0), nullptr,
                          nullptr, formatFor(span, value).c_str(), ImGuiSliderFlags_NoRoundToFormat);
    note(panel.actions, changed);
    return changed;
}

bool drawRange(const NumbersPanel& panel, proto::Selection::Range& range) {
    std::vector<std::string_view> names;
    for (const auto& quantity : panel.quantities) names.emplace_back(quantity.name);
    std::string column = range.column();
    ImGui::SetNextItemWidth(70.0F * panel.scale);
    bool changed = chooseName("##column", column, names);
    const auto* quantity = findQuantity(panel.quantities, column);
    const Interval ends = quantity != nullptr && quantity->range ? *quantity->range : Interval{};
    if (changed) {
        range.Clear();
        range.set_column(column);
    }
    double low = range.has_min() ? range.min() : ends.low, high = range.has_max() ? range.max() : ends.high;
    for (const auto& [label, value] : {std::pair{"##low", &low}, {"##high", &high}}) {
        ImGui::SameLine();
        ImGui::SetNextItemWidth(88.0F * panel.scale);
        if (!dragNumber(panel, label, *value, ends)) continue;
        value == &low ? range.set_min(low) : range.set_max(std::max(low, high));
        if (range.has_max() && range.has_min() && range.min() > range.max()) range.set_max(range.min());
        changed = true;
    }
    ImGui::SameLine();
    dim(quantity != nullptr && quantity->unit != "1" ? quantity->unit : "");
    return changed;
}

bool drawDensity(const NumbersPanel& panel, proto::Selection::Density& density) {
    float low = static_cast<float>(density.has_min() ? density.min() : 0.0);
    float high = static_cast<float>(density.has_max() ? density.max() : 1.0);
    const std::array<float, 2> before{low, high};
    const bool changed = ImGui::DragFloatRange2("log density", &low, &high, 0.002F, 0.0F, 1.0F, "%.3f",
                                                nullptr, ImGuiSliderFlags_AlwaysClamp);
    note(panel.actions, changed);
    if (!changed) return false;
    if (low != before[0]) density.set_min(decimal(low));
    if (high != before[1]) density.set_max(decimal(high));
    return true;
}

bool drawOutermost(const NumbersPanel& panel, proto::Selection::Outermost& outermost) {
    static constexpr std::array<std::string_view, 3> planes{"x", "y", "z"};
    std::string plane = outermost.plane();
    ImGui::SetNextItemWidth(50.0F * panel.scale);
    bool changed = chooseName("##plane", plane, planes);
    outermost.set_plane(plane);
    float percent = static_cast<float>(100.0 * outermost.share());
    ImGui::SameLine();
    ImGui::SetNextItemWidth(110.0F * panel.scale);
    const bool slid = ImGui::SliderFloat("outermost", &percent, 0.01F, 100.0F, "%.2f%%",
                                         ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic);
    note(panel.actions, slid);
    if (slid) outermost.set_share(std::clamp(percent / 100.0, 0.0, 1.0));
    return changed || slid;
}

bool drawParts(const NumbersPanel& panel, proto::Selection& selection);

bool drawList(const NumbersPanel& panel, google::protobuf::RepeatedPtrField<proto::Selection>& parts,
              const char* title) {
    bool changed = false;
    if (!parts.empty()) dim(title);
    ImGui::Indent(10.0F * panel.scale);
    for (int i = 0; i < parts.size(); ++i) {
        ImGui::PushID(title);
        ImGui::PushID(i);
        changed |= drawParts(panel, parts[i]);
        ImGui::PopID();
        ImGui::PopID();
    }
    ImGui::Unindent(10.0F * panel.scale);
    return changed;
}

bool drawParts(const NumbersPanel& panel, proto::Selection& selection) {
    bool changed = false;
    if (!selection.named().empty()) text(selection.named());
    for (int i = 0; i < selection.ranges_size(); ++i) {
        ImGui::PushID(i);
        changed |= drawRange(panel, *selection.mutable_ranges(i));
        ImGui::PopID();
    }
    if (selection.has_density()) changed |= drawDensity(panel, *selection.mutable_density());
    if (selection.has_outermost()) changed |= drawOutermost(panel, *selection.mutable_outermost());
    proto::Selection shape;
    if (selection.has_polygon()) *shape.mutable_polygon() = selection.polygon();
    if (selection.has_lasso()) *shape.mutable_lasso() = selection.lasso();
    *shape.mutable_ids() = selection.ids();
    shape.set_nothing(selection.nothing());
    if (shape.ByteSizeLong() > 0) dim(describe(shape));
    changed |= drawList(panel, *selection.mutable_all(), "all of");
    changed |= drawList(panel, *selection.mutable_any(), "any of");
    if (!selection.has_negated()) return changed;
    dim("not");
    ImGui::PushID("not");
    ImGui::Indent(10.0F * panel.scale);
    changed |= drawParts(panel, *selection.mutable_negated());
    ImGui::Unindent(10.0F * panel.scale);
    ImGui::PopID();
    return changed;
}

}  // namespace

void edit(const NumbersPanel& panel, const proto::Selection& selection) {
    panel.controls.say(panel.model.replace(*panel.model.chosen(), selection));
    panel.actions.viewChanged = true;
}

void drawConditions(const NumbersPanel& panel, const proto::NamedSelection& chosen) {
    proto::Selection edited = chosen.selection();
    bool changed = drawParts(panel, edited);
    bool follows = edited.has_step();
    ImGui::BeginDisabled(!panel.manifest.ids());
    const auto step = follows ? edited.step() : panel.step;
    if (ImGui::Checkbox(fmt::format("as it is in step {}###follows", step).c_str(), &follows)) {
        follows ? edited.set_step(step) : edited.clear_step();
        changed = true;
    }
    ImGui::EndDisabled();
    if (changed) edit(panel, edited);
    drawName(panel, chosen);  // last: it may delete what is edited
}

}  // namespace mote::client
