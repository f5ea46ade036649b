// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/changed_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace mote::client {

/// What triangles cover at most, in screen coordinates; empty at first.
struct ChangedParts::Span {
    float left = std::numeric_limits<float>::max(), top = left;
    float right = std::numeric_limits<float>::lowest(), bottom = right;

    void add(const Triangle& triangle) {
        const auto& [a, b, c] = triangle.corners;
        const auto& clip = triangle.clip;
        const float x0 = std::max(std::min({a.pos.x, b.pos.x, c.pos.x}), clip.x);
        const float x1 = std::min(std::max({a.pos.x, b.pos.x, c.pos.x}), clip.z);
        const float y0 = std::max(std::min({a.pos.y, b.pos.y, c.pos.y}), clip.y);
        const float y1 = std::min(std::max({a.pos.y, b.pos.y, c.pos.y}), clip.w);
        if (x0 > x1 || y0 > y1) return;
        left = std::min(left, x0);
        top = std::min(top, y0);
        right = std::max(right, x1);
        bottom = std::max(bottom, y1);
    }

    void add(std::span<const Triangle> triangles) {
        for (const auto& each : triangles) add(each);
    }

    /// With a pixel around it, for ends of clips are rounded.
    std::optional<WindowPart> within(const ImDrawData& data) const {
        if (left > right || top > bottom) return std::nullopt;
        const auto& place = data.DisplayPos;
        const auto pixel = [](float coordinate, float most) {
            return static_cast<int>(std::clamp(coordinate, 0.0F, most));
        };
        const WindowPart part{pixel(std::floor(left - place.x) - 1.0F, data.DisplaySize.x),
                              pixel(std::floor(top - place.y) - 1.0F, data.DisplaySize.y),
                              pixel(std::ceil(right - place.x) + 1.0F, data.DisplaySize.x),
                              pixel(std::ceil(bottom - place.y) + 1.0F, data.DisplaySize.y)};
        return part.pixels() > 0 ? std::optional(part) : std::nullopt;
    }
};

namespace {

/// The pixels that a clip leaves, as Dear ImGui's OpenGL backend rounds it.
WindowPart pixelsOf(const ImVec4& clip, const ImDrawData& data) {
    const auto& place = data.DisplayPos;
    const int left = static_cast<int>(clip.x - place.x), width = static_cast<int>(clip.z - clip.x);
    const int height = static_cast<int>(clip.w - clip.y);
    const int below = static_cast<int>(data.DisplaySize.y - (clip.w - place.y));
    const int bottom = static_cast<int>(data.DisplaySize.y) - below;
    return {left, bottom - height, left + width, bottom};
}

bool same(const ImVec2& one, const ImVec2& other) {
    return one.x == other.x && one.y == other.y;
}

}  // namespace

std::vector<ImVec4> ChangedParts::clipTo(ImDrawData& data, const WindowPart& part) {
    std::vector<ImVec4> clips;
    const auto& place = data.DisplayPos;
    for (int i = 0; i < data.CmdListsCount; ++i) {
        for (auto& command : data.CmdLists[i]->CmdBuffer) {
            auto& clip = command.ClipRect;
            clips.push_back(clip);
            const auto own = pixelsOf(clip, data);
            const int left = std::max(own.left, part.left), right = std::min(own.right, part.right);
            const int top = std::max(own.top, part.top), bottom = std::min(own.bottom, part.bottom);
            const bool drawn = left < right && top < bottom;
            const auto at = [](int pixel, float begin) { return static_cast<float>(pixel) + begin; };
            clip = drawn
                       ? ImVec4(at(left, place.x), at(top, place.y), at(right, place.x), at(bottom, place.y))
                       : ImVec4();
        }
    }
    return clips;
}

void ChangedParts::restoreClips(ImDrawData& data, const std::vector<ImVec4>& clips) {
    auto clip = clips.begin();
    for (int i = 0; i < data.CmdListsCount; ++i) {
        for (auto& command : data.CmdLists[i]->CmdBuffer) command.ClipRect = *clip++;
    }
}

/// False if it draws by a function of its own.
bool ChangedParts::append(const ImDrawList& list, std::vector<Triangle>& triangles) {
    for (const auto& command : list.CmdBuffer) {
        if (command.UserCallback != nullptr) return false;
        const auto* indices = list.IdxBuffer.Data + command.IdxOffset;
        const auto* corners = list.VtxBuffer.Data + command.VtxOffset;
        for (unsigned i = 0; i + 2 < command.ElemCount; i += 3) {
            triangles.push_back({{corners[indices[i]], corners[indices[i + 1]], corners[indices[i + 2]]},
                                 command.ClipRect,
                                 command.GetTexID()});
        }
    }
    return true;
}

bool ChangedParts::differs(const Triangle& one, const Triangle& other) const {
    const auto alike = [](const ImDrawVert& a, const ImDrawVert& b) {
        return same(a.pos, b.pos) && same(a.uv, b.uv) && a.col == b.col;
    };
    const auto &clip = one.clip, &with = other.clip;
    return one.texture != other.texture || !std::ranges::equal(one.corners, other.corners, alike) ||
           clip.x != with.x || clip.y != with.y || clip.z != with.z || clip.w != with.w ||
           touched_.contains(other.texture);
}

/// Triangles that come in the same order and are the same leave a pixel the same, wherever none of the others
/// lies: those between equal beginnings and equal ends or, where both have as many, those that differ.
ChangedParts::Span ChangedParts::spanOfChanges(const List& before, const List& now) const {
    Span span;
    const auto &old = before.triangles, &young = now.triangles;
    if (old.size() == young.size()) {
        for (std::size_t i = 0; i < old.size(); ++i) {
            if (!differs(old[i], young[i])) continue;
            span.add(old[i]);
            span.add(young[i]);
        }
        return span;
    }
    const std::size_t least = std::min(old.size(), young.size());
    std::size_t begin = 0, end = 0;
    while (begin < least && !differs(old[begin], young[begin])) ++begin;
    while (end < least - begin && !differs(old[old.size() - 1 - end], young[young.size() - 1 - end])) ++end;
    span.add(std::span(old).subspan(begin, old.size() - begin - end));
    span.add(std::span(young).subspan(begin, young.size() - begin - end));
    return span;
}

std::optional<std::vector<WindowPart>> ChangedParts::take(const ImDrawData& data) {
    std::vector<List> lists(static_cast<std::size_t>(data.CmdListsCount));
    bool plain = true;
    for (std::size_t i = 0; i < lists.size(); ++i) {
        const auto& list = *data.CmdLists[i];
        lists[i].name = list._OwnerName != nullptr ? list._OwnerName : "";
        plain &= append(list, lists[i].triangles);
    }
    plain &= same(data.FramebufferScale, {1.0F, 1.0F});
    const bool compared = known_ && plain && same(place_, data.DisplayPos) && same(size_, data.DisplaySize);
    known_ = plain;
    place_ = data.DisplayPos;
    size_ = data.DisplaySize;
    const auto before = std::exchange(lists_, std::move(lists));
    std::vector<WindowPart> parts;
    for (const auto& span : changesSince(before)) {
        if (const auto part = span.within(data)) parts.push_back(*part);
    }
    touched_.clear();
    return compared ? std::optional(parts) : std::nullopt;
}

/// Windows that came, went or changed places lie between those that did not.
std::vector<ChangedParts::Span> ChangedParts::changesSince(const std::vector<List>& before) const {
    const std::size_t least = std::min(before.size(), lists_.size());
    std::size_t front = 0, back = 0;
    while (front < least && before[front].name == lists_[front].name) ++front;
    const auto fromBack = [](const std::vector<List>& lists, std::size_t i) -> const List& {
        return lists[lists.size() - 1 - i];
    };
    while (back < least - front && fromBack(before, back).name == fromBack(lists_, back).name) ++back;
    std::vector<Span> spans;
    for (std::size_t i = 0; i < front; ++i) spans.push_back(spanOfChanges(before[i], lists_[i]));
    for (std::size_t i = front; i + back < before.size(); ++i) spans.push_back(spanOfChanges(before[i], {}));
    for (std::size_t i = front; i + back < lists_.size(); ++i) spans.push_back(spanOfChanges({}, lists_[i]));
    for (std::size_t i = 0; i < back; ++i)
        spans.push_back(spanOfChanges(fromBack(before, i), fromBack(lists_, i)));
    return spans;
}

}  // namespace mote::client
