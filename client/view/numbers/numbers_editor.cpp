// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/numbers_editor.h"

#include <fmt/format.h>
#include <imgui.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "client/shared/numbers.h"
#include "client/view/numbers/numbers_panel.h"
#include "client/view/numbers/quantities.h"
#include "client/view/view_model.h"

namespace mote::client {
namespace {

constexpr float marginalShare = 0.14F;  // of the plot's sides
constexpr float closes = 9.0F;          // pixels around the first corner

/// The weights along an edge of the plot, as steps: above it, or at its right.
void drawMarginal(const PlotFrame& frame, const std::vector<double>& sums, bool right) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const double most = *std::max_element(sums.begin(), sums.end());
    if (!(most > 0.0)) return;
    const float length = right ? frame.to.y - frame.from.y : frame.to.x - frame.from.x;
    const float room = marginalShare * (right ? frame.to.x - frame.from.x : frame.to.y - frame.from.y);
    const float each = length / static_cast<float>(sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const float high = room * static_cast<float>(std::max(sums[i], 0.0) / most);
        const float at = each * static_cast<float>(i);
        if (right) {
            draw.AddRectFilled({frame.to.x + 2.0F, frame.to.y - at - each},
                               {frame.to.x + 2.0F + high, frame.to.y - at}, IM_COL32(140, 200, 255, 130));
        } else {
            draw.AddRectFilled({frame.from.x + at, frame.from.y - 2.0F - high},
                               {frame.from.x + at + each, frame.from.y - 2.0F}, IM_COL32(140, 200, 255, 130));
        }
    }
}

void drawLine(const PlotFrame& frame, const std::vector<glm::dvec2>& corners, ImU32 color, bool closed) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    for (const auto& corner : corners) draw.PathLineTo(frame.at(corner.x, corner.y));
    draw.PathStroke(color, closed ? ImDrawFlags_Closed : 0, 2.0F);
}

}  // namespace

std::vector<glm::dvec2> HistogramWindow::draw(const NumbersPanel& panel, float width, float height) {
    const float side = std::clamp(0.62F * std::min(width, height), 280.0F, 620.0F);
    ImGui::SetNextWindowPos({16.0F * panel.scale, 16.0F * panel.scale}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({side, 1.05F * side}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowBgAlpha(0.94F);
    std::vector<glm::dvec2> polygon;
    if (ImGui::Begin("Histogram", &panel.controls.histogramShown, ImGuiWindowFlags_NoCollapse)) {
        drawControls(panel);
        const auto histogram = panel.data.histogram();
        if (!histogram.failure.empty()) dim(histogram.failure);
        if (histogram.value) {
            for (const auto& note : histogram.value->notes) dim(note);
            polygon = drawPlot(panel, *histogram.value);
        }
    }
    ImGui::End();
    return polygon;
}

void HistogramWindow::drawControls(const NumbersPanel& panel) {
    auto& view = panel.controls.histogram;
    view.fit(panel.quantities);
    std::vector<std::string_view> names;
    for (const auto& quantity : panel.quantities) names.emplace_back(quantity.name);
    for (std::size_t axis = 0; axis < 2; ++axis) {
        ImGui::SetNextItemWidth(80.0F * panel.scale);
        auto chosen = view.columns[axis];
        if (chooseName(axis == 0 ? "##first" : "##second", chosen, names)) view.setColumn(axis, chosen);
        ImGui::SameLine();
    }
    ImGui::Checkbox("log", &view.logScale);
    ImGui::SameLine();
    ImGui::BeginDisabled(!panel.model.chosen());
    ImGui::Checkbox("selection", &view.ofSelection);
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::SetNextItemWidth(90.0F * panel.scale);
    chooseColorMap("##colours", view.colorMap);
    ImGui::SameLine();
    if (ImGui::Button("All")) view.showAll();
}

void HistogramWindow::upload(const StepHistogram& histogram, const HistogramView& view) {
    const auto look = fmt::format("{} {} {}", view.colorMap, view.logScale, histogram.bins(0));
    if (texture_ && look == shownLook_ && histogram.counts == shownCounts_) return;
    const auto map = ColorMap::find(view.colorMap);
    const auto picture = pictureOf(histogram, map.ok() ? *map : ColorMap::standard(), view.logScale);
    if (!texture_) texture_ = std::make_unique<PictureTexture>();
    texture_->upload(picture.pixels, picture.width, picture.height);
    shownCounts_ = histogram.counts;
    shownLook_ = look;
}

std::vector<glm::dvec2> HistogramWindow::drawPlot(const NumbersPanel& panel, const StepHistogram& histogram) {
    upload(histogram, panel.controls.histogram);
    const ImVec2 origin = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
    const ImVec2 size{std::max(room.x, 120.0F), std::max(room.y - ImGui::GetFrameHeight(), 120.0F)};
    ImGui::InvisibleButton("plot", size,
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
    const bool hovered = ImGui::IsItemHovered();
    const ImVec2 margin = plotMargin();
    const float inner = 1.0F / (1.0F + marginalShare), letter = ImGui::GetFontSize();
    const float plotWidth = (size.x - margin.x) * inner,
                plotHeight = (size.y - margin.y - 1.3F * letter) * inner;
    const PlotFrame frame{{origin.x + margin.x, origin.y + size.y - margin.y - plotHeight},
                          {origin.x + margin.x + plotWidth, origin.y + size.y - margin.y},
                          {histogram.edges[0].front(), histogram.edges[0].back()},
                          {histogram.edges[1].front(), histogram.edges[1].back()}};
    drawGround(frame);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.AddImage(texture_->handle(), frame.from, frame.to);
    const bool over = hovered && frame.holds(ImGui::GetIO().MousePos);
    draw.PushClipRect(frame.from, frame.to, true);
    drawPolygons(panel, frame, over);
    draw.PopClipRect();
    const auto units = columnUnits(panel.manifest);
    const auto unit = [&](std::size_t i) { return unitOfColumn(histogram.columns[i], units); };
    drawMarginal(frame, marginalOf(histogram, 0), false);
    drawMarginal(frame, marginalOf(histogram, 1), true);
    drawAxes(frame, {histogram.columns[0], unit(0), histogram.columns[1], unit(1)});
    dim(fmt::format("step {}, {}{}", histogram.step,
                    metric(static_cast<double>(histogram.particles), "particles"),
                    panel.data.histogram().waits ? ", counting ..." : ""));
    if (over) {
        ImGui::SameLine(0.0F, 24.0F);
        dim("click corners, the first again to close; wheel zooms");
        zoom(panel, frame);
    }
    if (cornersOf_ != panel.controls.histogram.columns) corners_.clear();
    cornersOf_ = panel.controls.histogram.columns;
    // A histogram of other columns is still on its way.
    const bool shown = std::ranges::equal(histogram.columns, panel.controls.histogram.columns);
    return shown ? takeClicks(frame, over) : std::vector<glm::dvec2>();
}

/// The chosen selection's polygon where it is of these columns, and the one under way.
void HistogramWindow::drawPolygons(const NumbersPanel& panel, const PlotFrame& frame, bool hovered) const {
    const auto& color = panel.model.highlightColor;
    const ImU32 shown = ImGui::ColorConvertFloat4ToU32({color[0], color[1], color[2], 1.0F});
    if (const auto* chosen = panel.model.chosenSelection()) {
        const auto& polygon = chosen->selection().polygon();
        if (std::ranges::equal(polygon.columns(), panel.controls.histogram.columns))
            drawLine(frame, cornersOf(polygon.points()), shown, true);
    }
    if (corners_.empty()) return;
    auto line = corners_;
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (hovered) line.emplace_back(frame.firstAt(mouse.x), frame.secondAt(mouse.y));
    drawLine(frame, line, IM_COL32(255, 255, 255, 230), false);
    for (const auto& corner : corners_)
        ImGui::GetWindowDrawList()->AddCircleFilled(frame.at(corner.x, corner.y), 4.0F, IM_COL32_WHITE);
}

void HistogramWindow::zoom(const NumbersPanel& panel, const PlotFrame& frame) const {
    const auto& io = ImGui::GetIO();
    auto& view = panel.controls.histogram;
    const ImVec2 mouse = io.MousePos;
    const auto place = fmt::format("{:.4g}, {:.4g}", frame.firstAt(mouse.x), frame.secondAt(mouse.y));
    ImGui::SetTooltip("%s", place.c_str());
    if (io.MouseWheel == 0.0F) return;
    const double factor = std::pow(0.85, static_cast<double>(io.MouseWheel));
    view.zoom(0, frame.x, frame.firstAt(mouse.x), factor);
    view.zoom(1, frame.y, frame.secondAt(mouse.y), factor);
}

/// A click sets a corner; at the first one, or a double click, it is closed. The right button takes one back.
std::vector<glm::dvec2> HistogramWindow::takeClicks(const PlotFrame& frame, bool hovered) {
    if (!hovered) return {};
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Right) && !corners_.empty()) corners_.pop_back();
    if (!ImGui::IsMouseClicked(ImGuiMouseButton_Left)) return {};
    bool closed = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    if (!corners_.empty()) {
        const ImVec2 first = frame.at(corners_.front().x, corners_.front().y);
        closed |= std::hypot(first.x - mouse.x, first.y - mouse.y) < closes;
    }
    if (closed && corners_.size() >= 3) return std::exchange(corners_, {});
    if (!closed) corners_.emplace_back(frame.firstAt(mouse.x), frame.secondAt(mouse.y));
    return {};
}

namespace {

constexpr const char* noColumns =
    "This dataset was made without columns: make it again from its source (mote-prep particles) to have its "
    "numbers.";

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
}

void NumbersEditor::drawOver(ViewModel& model, const proto::Manifest* manifest, const PictureArea& area,
                             PanelActions& actions, bool moving) {
    const bool particles = manifest != nullptr && model.kind() == proto::Layer::kParticles;
    const auto quantities = particles ? quantitiesOf(manifest->particles()) : std::vector<Quantity>();
    ids_ = particles && manifest->particles().ids();
    if (!particles) controls_.tool.setKind(PictureTool::Kind::none);
    const bool histogram = particles && controls_.histogramShown && quantities.size() >= 2;
    if (histogram) {
        const NumbersPanel panel{model.numbers, controls_,    data_,      manifest->particles(),
                                 quantities,    model.step(), area.scale, actions};
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

bool NumbersEditor::takeMouse(ViewModel& model, const proto::Manifest* manifest, const PictureArea& area,
                              PanelActions& actions) {
    if (model.kind() != proto::Layer::kParticles) return false;
    const ImGuiIO& io = ImGui::GetIO();
    PictureTool::Mouse mouse{area.partAt(io.MousePos.x, io.MousePos.y),
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
        const double aspect = area.aspect();
        auto gesture = lassoOn(model.camera(aspect), aspect, model.layer(), model.layerToWorld(), done.lasso);
        if (manifest != nullptr)
            sayPlot(manifest->particles(), model.step(), controls_.follow && ids_, *gesture.mutable_lasso());
        takeGesture(model, gesture, "lasso", actions);
        open = true;
    }
    if (done.pick) {
        proto::PickQuery place;
        *place.mutable_view() = model.view(area.columns, area.rows);
        place.mutable_view()->mutable_layers()->SwapElements(0, model.chosen());  // it is the first's
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

void NumbersEditor::drawTool(const PictureArea& area) const {
    const auto kind = controls_.tool.kind();
    if (kind == PictureTool::Kind::none) return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const auto* said = kind == PictureTool::Kind::lasso
                           ? "Lasso: draw a line around particles (L or Esc ends)"
                           : "Pick: click on a point (P or Esc ends)";
    drawSign(area, said);
    const auto& line = controls_.tool.line();
    for (const auto& place : line)
        draw.PathLineTo({area.left + static_cast<float>(place.x) * area.width,
                         area.top + static_cast<float>(place.y) * area.height});
    draw.PathStroke(IM_COL32(255, 255, 255, 235), ImDrawFlags_Closed, 2.0F);
}

}  // namespace mote::client
