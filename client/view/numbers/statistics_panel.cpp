// SPDX-License-Identifier: GPL-3.0-or-later
//
// Statistics of the step and of the chosen selection, side by side.
#include <fmt/format.h>
#include <imgui.h>

#include "client/view/numbers/numbers_panel.h"
#include "client/view/numbers/plot_frame.h"
#include "client/view/numbers/quantities.h"

namespace mote::client {
namespace {

std::optional<StepStatistics> wholeStep(const NumbersPanel& panel) {
    if (panel.step >= static_cast<std::uint32_t>(panel.manifest.steps_size())) return std::nullopt;
    if (panel.manifest.statistic_names().empty()) return panel.data.whole().value;
    const auto whole = statisticsOf(panel.manifest, {panel.step});
    if (!whole.ok()) return std::nullopt;
    return whole->front();
}

void rightText(const std::string& line) {
    const float edge = 0.3F * ImGui::GetFontSize();
    const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(line.c_str()).x - edge;
    if (room > 0.0F) ImGui::SetCursorPosX(ImGui::GetCursorPosX() + room);
    text(line);
}

void drawRows(const NumbersPanel& panel, const std::vector<StatisticRow>& rows, std::string head,
              float height) {
    constexpr auto flags = ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY | ImGuiTableFlags_BordersInnerV;
    if (!ImGui::BeginTable("statistics", 3, flags, {0.0F, height})) return;
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("");
    ImGui::TableSetupColumn("all");
    ImGui::TableSetupColumn(head.c_str());
    ImGui::TableHeadersRow();
    for (const auto& row : rows) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        const bool plotted = panel.controls.series == row.name;
        if (ImGui::Selectable(row.name.c_str(), plotted, ImGuiSelectableFlags_SpanAllColumns))
            panel.controls.series = row.name;
        ImGui::TableNextColumn();
        rightText(row.whole);
        ImGui::TableNextColumn();
        rightText(row.selected);
    }
    ImGui::EndTable();
}

}  // namespace

std::optional<std::uint32_t> drawStatistics(const NumbersPanel& panel) {
    if (!section("Statistics")) return std::nullopt;
    const auto whole = wholeStep(panel);
    const auto selected = panel.data.selected();
    if (!whole && !selected.value && !selected.waits)
        dim("The dataset was made without statistics: make it again (mote-prep particles) to have them.");
    const auto units = columnUnits(panel.manifest);
    const auto rows = statisticRows(whole, selected.value, units, panel.controls.allStatistics);
    const auto* chosen = panel.model.chosenSelection();
    std::string head = chosen != nullptr ? chosen->name() : std::string();
    // An older answer is shown with its own step.
    if (selected.value && selected.value->step != panel.step)
        head += fmt::format(" (step {})", selected.value->step);
    if (selected.waits) head += " ...";
    if (!rows.empty()) drawRows(panel, rows, head, 205.0F * panel.scale);
    if (!selected.failure.empty()) dim(selected.failure);
    if (selected.value) {
        for (const auto& note : selected.value->notes) dim(note);
    }
    ImGui::Checkbox("all statistics", &panel.controls.allStatistics);
    const auto values = seriesOf(panel.manifest, panel.controls.series);
    const auto series = panel.data.series();
    if (!series.failure.empty()) dim(series.failure);
    SeriesPlot plot{panel.controls.series,
                    unitOf(panel.controls.series, units),
                    values,
                    {},
                    panel.model.highlightColor,
                    panel.step,
                    150.0F * panel.scale};
    if (series.value) plot.selected = *series.value;
    return drawSeries(plot);
}

}  // namespace mote::client
