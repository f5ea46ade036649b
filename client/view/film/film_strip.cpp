// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/film/film_strip.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace mote::client {
namespace {

constexpr float rulerHeight = 34.0F, padding = 6.0F;  // at a scale of 1, as below
constexpr float dragThreshold = 3.0F;                 // pixels that a click may slip
constexpr ImU32 groundColor = IM_COL32(18, 20, 26, 255), lineColor = IM_COL32(255, 255, 255, 60);
constexpr ImU32 textColor = IM_COL32(255, 255, 255, 150), emptyColor = IM_COL32(46, 52, 64, 255);
constexpr ImU32 plainColor = IM_COL32(150, 160, 175, 255), selectedColor = IM_COL32(255, 176, 84, 255);
constexpr ImU32 playheadColor = IM_COL32(140, 200, 255, 255), shadeColor = IM_COL32(0, 0, 0, 170);

}  // namespace

FilmStrip::Touch FilmStrip::draw(FilmModel& model, const ThumbnailHandles& thumbnails, float height,
                                 float scale) {
    const ImVec2 origin = ImGui::GetCursorScreenPos();
    const float width = std::max(ImGui::GetContentRegionAvail().x, 8.0F * scale);
    ImGui::InvisibleButton("strip", {width, height});
    area_ = {origin.x, origin.y, origin.x + width, origin.y + height};
    pictureHeight_ = height - (rulerHeight + 2.0F * padding) * scale;
    const auto [wide, high] = model.size();
    const float proportion = high > 0 ? static_cast<float>(wide) / static_cast<float>(high) : 16.0F / 9.0F;
    pictureWidth_ = pictureHeight_ * std::clamp(proportion, 0.5F, 2.4F);
    if (!held_)
        scale_ = StripScale::of(model.begin(), model.end(), origin.x, width, pictureWidth_ / 2.0F + padding);
    const Touch touch = takeMouse(model);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.PushClipRect(origin, {area_.right, area_.bottom}, true);
    draw.AddRectFilled(origin, {area_.right, area_.bottom}, groundColor, 4.0F * scale);
    drawRuler(scale);
    drawWays(model, scale);
    for (std::size_t i = 0; i < model.keyframes().size(); ++i) {
        if (i != model.selected()) drawKeyframe(model, i, thumbnails(model.keyframes()[i].picture), scale);
    }
    if (const auto selected = model.selected())
        drawKeyframe(model, *selected, thumbnails(model.keyframes()[*selected].picture), scale);
    if (!model.empty()) drawPlayhead(model, scale);
    draw.PopClipRect();
    return touch;
}

FilmStrip::Box FilmStrip::boxOf(const FilmModel& model, std::size_t keyframe) const {
    const float middle = scale_.at(model.keyframes()[keyframe].seconds);
    const float top = area_.top + padding;
    return {middle - pictureWidth_ / 2.0F, top, middle + pictureWidth_ / 2.0F, top + pictureHeight_};
}

/// The one that is drawn above the others.
std::optional<std::size_t> FilmStrip::keyframeAt(const FilmModel& model, float x, float y) const {
    if (model.selected() && boxOf(model, *model.selected()).holds(x, y)) return model.selected();
    for (std::size_t i = model.keyframes().size(); i-- > 0;)
        if (boxOf(model, i).holds(x, y)) return i;
    return std::nullopt;
}

FilmStrip::Touch FilmStrip::takeMouse(FilmModel& model) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (model.empty()) return Touch::none;
    if (ImGui::IsItemActivated()) return press(model, mouse.x, mouse.y);
    held_ = held_ && ImGui::IsItemActive();
    return held_ ? drag(model, mouse.x) : Touch::none;
}

FilmStrip::Touch FilmStrip::press(FilmModel& model, float x, float y) {
    held_ = true;
    dragged_ = false;
    pressedAt_ = x;
    keyframe_ = keyframeAt(model, x, y);
    if (keyframe_) {
        grip_ = x - scale_.at(model.keyframes()[*keyframe_].seconds);
        model.select(*keyframe_);
        return Touch::selected;
    }
    model.setPlayhead(scale_.from(x));
    return Touch::scrubbed;
}

FilmStrip::Touch FilmStrip::drag(FilmModel& model, float x) {
    dragged_ |= std::abs(x - pressedAt_) > dragThreshold;
    const auto& moved = ImGui::GetIO().MouseDelta;
    if (!dragged_ || (moved.x == 0.0F && moved.y == 0.0F)) return Touch::none;
    if (keyframe_ && *keyframe_ < model.keyframes().size()) {
        model.move(*keyframe_, scale_.from(x - grip_));
        return Touch::moved;
    }
    model.setPlayhead(scale_.from(x));
    return Touch::scrubbed;
}

void FilmStrip::drawRuler(float scale) const {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float top = area_.bottom - rulerHeight * scale;
    draw.AddLine({area_.left, top}, {area_.right, top}, lineColor);
    const double spacing = scale_.markSpacing(70.0F * scale);
    const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(spacing) - 1e-9)), 0, 6);
    const auto first = static_cast<std::int64_t>(std::ceil(scale_.begin / spacing - 1e-9));
    const auto count = static_cast<std::int64_t>((scale_.end - scale_.begin) / spacing) + 1;
    for (auto i = first; i < first + count; ++i) {
        const double seconds = static_cast<double>(i) * spacing;
        const float x = scale_.at(seconds);
        const auto label = fmt::format("{:.{}f} s", seconds, digits);
        draw.AddLine({x, top + 16.0F * scale}, {x, area_.bottom}, lineColor);
        draw.AddText({x + 3.0F * scale, area_.bottom - ImGui::GetFontSize() - 1.0F}, textColor,
                     label.c_str());
    }
}

/// How the film goes from one keyframe to the next: a line, an S, a step.
void FilmStrip::drawWays(const FilmModel& model, float scale) const {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float top = area_.bottom - (rulerHeight - 4.0F) * scale, high = 9.0F * scale;
    const auto& keyframes = model.keyframes();
    for (std::size_t i = 0; i + 1 < keyframes.size(); ++i) {
        const float left = scale_.at(keyframes[i].seconds), right = scale_.at(keyframes[i + 1].seconds);
        const auto easing = model.constantSpeed() ? Easing::linear : keyframes[i].easing;
        const auto point = [&](float share, double way) {
            return ImVec2(left + (right - left) * share, top + high * static_cast<float>(1.0 - way));
        };
        constexpr int pieces = 20;
        for (int piece = 0; piece <= pieces; ++piece) {
            const double share = static_cast<double>(piece) / pieces;
            if (piece == pieces && easing == Easing::hold) draw.PathLineTo(point(1.0F, 0.0));
            draw.PathLineTo(point(static_cast<float>(share), eased(easing, share)));
        }
        draw.PathStroke(i == model.selected() ? selectedColor : plainColor, 0, 1.5F * scale);
    }
}

void FilmStrip::drawKeyframe(const FilmModel& model, std::size_t keyframe, void* thumbnail,
                             float scale) const {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const Box box = boxOf(model, keyframe);
    const bool selected = keyframe == model.selected();
    const ImU32 color = selected ? selectedColor : plainColor;
    const ImVec2 from{box.left, box.top}, to{box.right, box.bottom};
    draw.AddRectFilled(from, to, emptyColor);
    if (thumbnail != nullptr) draw.AddImage(thumbnail, from, to);
    const auto number = fmt::format("{}", keyframe + 1);
    const ImVec2 size = ImGui::CalcTextSize(number.c_str());
    draw.AddRectFilled(from, {from.x + size.x + 8.0F * scale, from.y + size.y + 2.0F * scale}, shadeColor);
    draw.AddText({from.x + 4.0F * scale, from.y + scale}, color, number.c_str());
    draw.AddRect(from, to, color, 0.0F, 0, (selected ? 2.0F : 1.0F) * scale);
    const float x = scale_.at(model.keyframes()[keyframe].seconds);
    const float foot = area_.bottom - rulerHeight * scale, side = 4.0F * scale;
    draw.AddLine({x, box.bottom}, {x, foot}, color, scale);
    draw.AddQuadFilled({x, foot - side}, {x + side, foot}, {x, foot + side}, {x - side, foot}, color);
}

void FilmStrip::drawPlayhead(const FilmModel& model, float scale) const {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float x = scale_.at(model.playhead()), side = 6.0F * scale;
    draw.AddLine({x, area_.top}, {x, area_.bottom}, playheadColor, 1.5F * scale);
    draw.AddTriangleFilled({x - side, area_.top}, {x + side, area_.top}, {x, area_.top + 1.4F * side},
                           playheadColor);
}

}  // namespace mote::client
