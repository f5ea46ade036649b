// SPDX-License-Identifier: GPL-3.0-or-later
//
// The chosen selection: its name, its step, its conditions.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cstring>

#include "client/view/numbers/numbers_panel.h"

namespace mote::client {
namespace {

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
