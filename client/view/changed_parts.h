// SPDX-License-Identifier: GPL-3.0-or-later
//
// ChangedParts: where a frame of the user interface differs from the one before, told from the triangles of
// which both consist, so that a window which a processor draws need draw and show no more than that. One
// owner, one thread; no window.
#pragma once

#include <imgui.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace mote::client {

/// Pixels of a window, from its upper left; right and bottom are beyond the last.
struct WindowPart {
    int left, top, right, bottom;

    long long pixels() const { return static_cast<long long>(right - left) * (bottom - top); }
    bool operator==(const WindowPart&) const = default;
};

class ChangedParts {
  public:
    /// Outside of the parts that this returns, `data` gives each pixel of the window the colour that the data
    /// of the last call gave it. They may overlap; none: nothing changed. Null: any pixel may be another, as
    /// at first, at another size, and with commands that are no triangles.
    std::optional<std::vector<WindowPart>> take(const ImDrawData& data);
    /// A texture has other pixels than at the last take(), or is drawn in another way.
    void touch(ImTextureID texture) { touched_.insert(texture); }
    /// What the window shows is lost: the next take() is as the first.
    void forget() { known_ = false; }

    /// Keeps of the commands what lies in a part; what they were is to be given back by restoreClips().
    static std::vector<ImVec4> clipTo(ImDrawData& data, const WindowPart& part);
    static void restoreClips(ImDrawData& data, const std::vector<ImVec4>& clips);

  private:
    struct Triangle {
        ImDrawVert corners[3];
        ImVec4 clip;
        ImTextureID texture;
    };
    /// Of one window of the user interface.
    struct List {
        std::string name;
        std::vector<Triangle> triangles;
    };
    struct Span;

    static bool append(const ImDrawList& list, std::vector<Triangle>& triangles);
    bool differs(const Triangle& one, const Triangle& other) const;
    Span spanOfChanges(const List& before, const List& now) const;
    std::vector<Span> changesSince(const std::vector<List>& before) const;

    std::vector<List> lists_;
    ImVec2 place_{}, size_{};
    std::set<ImTextureID> touched_;
    bool known_ = false;
};

}  // namespace mote::client
