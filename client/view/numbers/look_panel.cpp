// SPDX-License-Identifier: GPL-3.0-or-later
//
// Colours by a column, the picked point and its path, what is written beside the picture.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "client/view/numbers/numbers_panel.h"
#include "client/view/numbers/quantities.h"
#include "protocol/scene/color_map.h"

namespace mote::client {
namespace {

constexpr std::string_view asLayer = "as the layer says";
constexpr std::array<std::string_view, 3> ofPixelNames{"by their opacity", "mean", "nearest"};

void drawColorRange(const NumbersPanel& panel, ColorByControls& colorBy) {
    const auto* quantity = findQuantity(panel.quantities, colorBy.column);
    checkbox(panel.actions, "own range", colorBy.ownRange);
    if (!colorBy.ownRange) {
        if (quantity == nullptr || !quantity->range) return;
        colorBy.low = quantity->range->low;
        colorBy.high = quantity->range->high;
        return;
    }
    double low = colorBy.low, high = colorBy.high;
    const double span = std::max(high - low, 1e-30);
    const auto format = formatFor(span, std::max(std::abs(low), std::abs(high)));
    for (const auto& [label, value] : {std::pair{"##from", &low}, std::pair{"##to", &high}}) {
        ImGui::SameLine();
        ImGui::SetNextItemWidth(88.0F * panel.scale);
        note(panel.actions,
             ImGui::DragScalar(label, ImGuiDataType_Double, value, static_cast<float>(span / 200.0), nullptr,
                               nullptr, format.c_str(), ImGuiSliderFlags_NoRoundToFormat));
    }
    if (!(low < high)) return;  // that would be no range
    colorBy.low = low;
    colorBy.high = high;
}

void drawPoint(const NumbersPanel& panel, const PickedPoint& point) {
    dim(fmt::format("step {}, row {} of the source, log density {:.3f}", point.step, point.row,
                    point.density));
    if (ImGui::BeginTable("point", 2, ImGuiTableFlags_RowBg)) {
        for (const auto& value : point.values) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            text(value.name);
            ImGui::TableNextColumn();
            text(numberText(value.value, value.unit));
        }
        ImGui::EndTable();
    }
    if (!point.id) return dim("The run has no ids: no path through the steps.");
    text(fmt::format("id {}", *point.id));
    ImGui::SameLine();
    if (!ImGui::Button("Path through the steps")) return;
    panel.controls.say(panel.model.addPath(*point.id));
    panel.actions.viewChanged = true;
}

}  // namespace

void drawColorBy(const NumbersPanel& panel) {
    if (!section("Colour by")) return;
    auto& colorBy = panel.model.colorBy;
    std::vector<std::string_view> names{asLayer};
    for (const auto& quantity : panel.quantities) names.emplace_back(quantity.name);
    std::string column = colorBy.column.empty() ? std::string(asLayer) : colorBy.column;
    if (chooseName("column", column, names)) {
        colorBy.column = column == asLayer ? "" : column;
        colorBy.ownRange = false;
        panel.actions.viewChanged = true;
    }
    fieldHelp(proto::ColorBy::default_instance(), proto::ColorBy::kColumnFieldNumber);
    if (colorBy.column.empty()) return;
    drawColorRange(panel, colorBy);
    colorMapList(panel.actions, "colours##by", colorBy.colorMap);
    std::string ofPixel = colorBy.ofPixel.empty() ? std::string(ofPixelNames.front()) : colorBy.ofPixel;
    if (chooseName("of a pixel's points", ofPixel, ofPixelNames)) {
        colorBy.ofPixel = ofPixel == ofPixelNames.front() ? "" : ofPixel;
        panel.actions.viewChanged = true;
    }
    fieldHelp(proto::ColorBy::default_instance(), proto::ColorBy::kOfPixelFieldNumber);
}

void drawPicked(const NumbersPanel& panel) {
    if (!section("Point")) return;
    auto& controls = panel.controls;
    const bool picking = controls.tool.kind() == PictureTool::Kind::pick;
    if (ImGui::Button(picking ? "Stop picking (P)" : "Pick (P)"))
        controls.tool.toggle(PictureTool::Kind::pick);
    ImGui::SameLine();
    dim("or Ctrl-click on the picture");
    const auto picked = panel.data.picked();
    if (picked.waits) dim("looking ...");
    if (!picked.failure.empty()) dim(picked.failure);
    if (picked.value && !*picked.value) dim("There is no point.");
    if (picked.value && *picked.value) drawPoint(panel, **picked.value);
    const auto paths = panel.model.pathIds().size();
    if (paths == 0) return;
    text(fmt::format("{} {}", paths, paths == 1 ? "path" : "paths"));
    ImGui::SameLine();
    if (ImGui::Button("Forget")) {
        panel.model.forgetPaths();
        panel.actions.viewChanged = true;
    }
    ImGui::SameLine();
    ImGui::SetNextItemWidth(90.0F * panel.scale);
    slider(panel.actions, "width", panel.model.pathWidth, 0.5F, 8.0F, "%.1f pixels");
}

void drawAnnotations(PanelActions& actions, proto::Annotations& annotations) {
    if (!section("Beside the picture")) return;
    bool axes = annotations.axes(), colorBar = annotations.color_bar();
    bool scaleBar = annotations.scale_bar(), labels = annotations.labels();
    const auto box = [&](const char* label, bool& shown, int field) {
        checkbox(actions, label, shown);
        fieldHelp(annotations, field);
    };
    box("axes", axes, annotations.kAxesFieldNumber);
    ImGui::SameLine();
    box("colour bar", colorBar, annotations.kColorBarFieldNumber);
    box("scale bar", scaleBar, annotations.kScaleBarFieldNumber);
    ImGui::SameLine();
    box("labels", labels, annotations.kLabelsFieldNumber);
    annotations.set_axes(axes);
    annotations.set_color_bar(colorBar);
    annotations.set_scale_bar(scaleBar);
    annotations.set_labels(labels);
    auto points = static_cast<float>(annotations.has_font_points() ? annotations.font_points() : 9.0);
    const float before = points;
    slider(actions, "font", points, 5.0F, 24.0F, "%.1f points");
    fieldHelp(annotations, annotations.kFontPointsFieldNumber);
    if (points != before) annotations.set_font_points(decimal(points));
}

}  // namespace mote::client
