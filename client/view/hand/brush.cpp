// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/hand/brush.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <string_view>

#include "client/view/layers/ink_editor.h"
#include "client/view/layers/layer_editor.h"
#include "client/view/panel_widgets.h"
#include "client/view/view_model.h"
#include "protocol/scene/ink_style.h"

namespace mote::client {
namespace {

constexpr double asideShare = 0.4;   // of the radius: so far apart places are asked for
constexpr double sameShare = 0.3;    // dabs nearer to each other are one
constexpr double alikeShare = 0.15;  // by how much radii of one region may differ that a hand chooses

glm::dvec3 dabAt(const proto::InkStyle::Region& region, int index) {
    return {region.dabs(3 * index), region.dabs(3 * index + 1), region.dabs(3 * index + 2)};
}

int dabsOf(const proto::InkStyle::Region& region) {
    return region.dabs_size() / 3;
}

bool isAlike(const proto::InkStyle::Region& region, const BrushSettings& settings, double radius) {
    const bool direction = region.has_direction_degrees() == settings.direction.has_value() &&
                           (!settings.direction || region.direction_degrees() == *settings.direction);
    return region.fill() == settings.fill && region.whole() == settings.whole && direction &&
           std::abs(region.radius() - radius) <= alikeShare * radius && dabsOf(region) < mostInkDabs;
}

/// The place of a drawing that the server found; nothing where it found none.
Result<std::optional<glm::dvec3>> placeOf(const proto::Answer& answer) {
    const auto& picked = answer.picked();
    if (!picked.found()) return std::optional<glm::dvec3>();
    if (picked.position_size() != 3 ||
        !std::ranges::all_of(picked.position(), [](double x) { return std::isfinite(x); }))
        return corrupt("answer.picked", "what the server found has no place");
    return std::optional(glm::dvec3(picked.position(0), picked.position(1), picked.position(2)));
}

InkEditor* inkEditorOf(ViewModel& model) {
    return dynamic_cast<InkEditor*>(&model.editor());
}

}  // namespace

double dabRadius(const BrushStroke& stroke, const glm::dvec3& place) {
    const auto inEye = stroke.camera.worldToEye() * stroke.layerToWorld * glm::dvec4(place, 1.0);
    const double depth = stroke.camera.perspective() ? -inEye.z : 1.0;
    const double world = stroke.settings.radius * 2.0 * stroke.camera.halfHeight() * depth / stroke.height;
    return world / std::cbrt(std::abs(glm::determinant(glm::dmat3(stroke.layerToWorld))));
}

Status paintDab(proto::InkStyle& style, const BrushStroke& stroke, const glm::dvec3& place) {
    const double radius = dabRadius(stroke, place);
    auto& regions = *style.mutable_regions();
    const auto& settings = stroke.settings;
    const bool goesOn = !regions.empty() && isAlike(regions[regions.size() - 1], settings, radius);
    if (!goesOn) {
        if (regions.size() >= mostInkRegions)
            return Error{ErrorCode::resourceExhausted, "ink.regions",
                         fmt::format("a layer has up to {} regions", mostInkRegions)};
        auto& added = *regions.Add();
        added.set_radius(radius);
        added.set_fill(settings.fill);
        added.set_whole(settings.whole);
        if (settings.direction) added.set_direction_degrees(*settings.direction);
    }
    auto& region = regions[regions.size() - 1];
    for (int i = 0; i < dabsOf(region); ++i) {
        if (glm::distance(dabAt(region, i), place) < sameShare * region.radius()) return success();
    }
    for (int axis = 0; axis < 3; ++axis) region.add_dabs(place[axis]);
    return success();
}

void eraseDabs(proto::InkStyle& style, double radius, const glm::dvec3& place) {
    auto& regions = *style.mutable_regions();
    for (int i = regions.size(); i-- > 0;) {
        auto& region = regions[i];
        for (int k = dabsOf(region); k-- > 0;) {
            if (glm::distance(dabAt(region, k), place) > radius) continue;
            const auto dab = region.dabs().begin() + std::ptrdiff_t{3} * k;
            region.mutable_dabs()->erase(dab, dab + 3);
        }
        if (region.dabs().empty()) regions.DeleteSubrange(i, 1);
    }
}

void Brush::resize(double turns) {
    constexpr double factor = 1.15;
    settings.radius =
        std::clamp(settings.radius * std::pow(factor, turns), BrushSettings::least, BrushSettings::most);
}

void Brush::begin(const ViewModel& model, const PictureArea& area) {
    stroke_ = std::make_shared<const BrushStroke>(BrushStroke{settings, model.camera(area.aspect()),
                                                              area.height / area.scale, model.layerToWorld(),
                                                              model.dataset(), model.chosen()});
    held_ = true;
}

void Brush::ask(const ViewModel& model, const PictureArea& area, glm::dvec2 at) {
    const auto part = area.partAt(at.x, at.y);
    proto::Query query;
    query.set_dataset(model.dataset());
    auto& pick = *query.mutable_pick();
    *pick.mutable_view() = model.view(area.columns, area.rows);
    auto& layers = *pick.mutable_view()->mutable_layers();
    layers.SwapElements(0, model.chosen());
    layers.DeleteSubrange(1, layers.size() - 1);
    pick.set_x(part.x * area.columns);
    pick.set_y(part.y * area.rows);
    questions_.push_back({std::move(query), ++ids_});
    strokes_[ids_] = stroke_;
    askedAt_ = at;
}

std::vector<Brush::Question> Brush::takeQuestions() {
    constexpr std::size_t most = 8;  // a server has many clients
    std::vector<Question> taken;
    for (; underWay_ < most && !questions_.empty(); ++underWay_) {
        taken.push_back(std::move(questions_.front()));
        questions_.pop_front();
    }
    return taken;
}

void Brush::hear(std::uint64_t id, const Result<proto::Answer>& answer) {
    const auto asked = strokes_.extract(id);
    if (asked.empty()) return;
    --underWay_;
    const auto place = answer.ok() ? placeOf(*answer) : answer.error();
    if (!place.ok()) {
        refused_ = place.error().toString();
    } else if (*place) {
        hits_.push_back({asked.mapped(), **place});
    }
}

bool Brush::paint(ViewModel& model) {
    const auto hits = std::exchange(hits_, {});
    auto* ink = inkEditorOf(model);
    if (hits.empty() || ink == nullptr) return false;
    const auto before = ink->style.SerializeAsString();
    for (const auto& [stroke, place] : hits) {
        if (stroke->layer != model.chosen() || stroke->dataset != model.dataset()) continue;
        if (stroke->settings.erases) {
            eraseDabs(ink->style, dabRadius(*stroke, place), place);
        } else if (const auto painted = paintDab(ink->style, *stroke, place); !painted.ok()) {
            refused_ = painted.error().toString();
        }
    }
    return ink->style.SerializeAsString() != before;
}

void Brush::drawRing(const PictureArea& area) const {
    const auto& mouse = ImGui::GetIO().MousePos;
    const auto radius = static_cast<float>(settings.radius) * area.scale;
    const auto color = settings.erases ? IM_COL32(255, 120, 110, 255) : IM_COL32(90, 160, 255, 255);
    auto& draw = *ImGui::GetBackgroundDrawList();
    draw.AddCircle(mouse, radius + area.scale, IM_COL32(20, 24, 32, 160), 0, 1.5F * area.scale);
    draw.AddCircle(mouse, radius, color, 0, 1.5F * area.scale);
}

bool Brush::takeMouse(ViewModel& model, const PictureArea& area, bool& changed) {
    changed |= paint(model);
    if (model.kind() != proto::Layer::kInk) on = held_ = false;
    if (!on) return false;
    const auto& io = ImGui::GetIO();
    const glm::dvec2 at(io.MousePos.x, io.MousePos.y);
    const bool over = area.holds(at.x, at.y) && !io.WantCaptureMouse;
    drawSign(area, settings.erases ? "Brush: a drag erases; wheel or [ ]: size (B or Esc ends)"
                                   : "Brush: a drag paints; wheel or [ ]: size (B or Esc ends)");
    if (over || held_) drawRing(area);
    const bool turned = over && io.MouseWheel != 0.0F;
    if (turned) resize(static_cast<double>(io.MouseWheel));
    if (over && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
        begin(model, area);
        ask(model, area, at);
    }
    const double apart = std::max(asideShare * settings.radius * area.scale, 2.0);
    // What the hand passed between two frames is painted too.
    while (held_ && area.holds(at.x, at.y) && glm::distance(at, askedAt_) >= apart)
        ask(model, area, askedAt_ + (at - askedAt_) * (apart / glm::distance(at, askedAt_)));
    const bool mine = held_ || turned;
    held_ = held_ && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    return mine;
}

namespace {

constexpr std::array<std::string_view, 5> fills{"as elsewhere", "hatch", "ink", "wash", "none"};

void drawSettings(Brush& brush) {
    auto& settings = brush.settings;
    ImGui::Checkbox("erase", &settings.erases);
    ImGui::SameLine();
    ImGui::Checkbox("whole regions", &settings.whole);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("of the picture, which the brush touches");
    auto radius = static_cast<float>(settings.radius);
    if (ImGui::SliderFloat("brush", &radius, static_cast<float>(BrushSettings::least),
                           static_cast<float>(BrushSettings::most), "%.0f", ImGuiSliderFlags_Logarithmic))
        settings.radius = std::clamp(static_cast<double>(radius), BrushSettings::least, BrushSettings::most);
    std::string fill(settings.fill.empty() ? fills[0] : settings.fill);
    if (chooseName("filled", fill, fills)) settings.fill = fill == fills[0] ? "" : fill;
    bool directed = settings.direction.has_value();
    if (ImGui::Checkbox("hatched along", &directed))
        settings.direction = directed ? std::optional(45.0) : std::nullopt;
    if (!settings.direction) return;
    auto degrees = static_cast<float>(*settings.direction);
    if (ImGui::SliderFloat("degrees", &degrees, -90.0F, 90.0F, "%.0f"))
        settings.direction = std::round(static_cast<double>(degrees));
}

std::string describe(const proto::InkStyle::Region& region) {
    auto said = region.fill().empty() ? std::string(fills[0]) : region.fill();
    if (region.has_direction_degrees()) said += fmt::format(", {:.0f} degrees", region.direction_degrees());
    return fmt::format("{}{}, {} dabs", said, region.whole() ? ", whole" : "", dabsOf(region));
}

}  // namespace

void drawBrush(ViewModel& model, Brush& brush, const LayerPanel& panel) {
    auto* ink = inkEditorOf(model);
    if (ink == nullptr || !section("Painted by hand")) return;
    ImGui::Checkbox("paint (B)", &brush.on);
    if (brush.on) drawSettings(brush);
    auto& regions = *ink->style.mutable_regions();
    for (int i = 0; i < regions.size(); ++i) {
        ImGui::PushID(i);
        const bool removed = ImGui::SmallButton("Remove");
        ImGui::SameLine();
        text(describe(regions[i]));
        ImGui::PopID();
        if (!removed) continue;
        regions.DeleteSubrange(i--, 1);
        panel.actions.viewChanged = true;
    }
}

}  // namespace mote::client
