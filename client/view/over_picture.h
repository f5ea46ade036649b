// SPDX-License-Identifier: GPL-3.0-or-later
//
// Notes: what the viewer has to say, on the picture: news that stay until they are put away, and what is
// wrong with what is shown, with what can be done about it. Main thread, within a Dear ImGui frame.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/scene/camera.h"

namespace mote::client {

struct Note {
    std::string sentence;
    /// What can be done, each a button.
    std::vector<std::pair<std::string, std::function<void()>>> ways = {};
};

/// The picture on the screen from its upper left corner on, screen coordinates, and pixels to one of them.
struct PictureArea {
    float width, height, scale;
};

class Notes {
  public:
    /// News are said once as long as they stand there; the oldest go where there are too many.
    void add(Note note);
    void clear(const std::string& sentence);
    /// Draws news at the lower right, what is wrong in the middle above; what the user chose is done after
    /// that.
    void draw(const PictureArea& area, const std::vector<Note>& wrong);

  private:
    static constexpr std::size_t most = 5;
    std::vector<Note> news_;
};

/// A side of what is shown: an axis, 0 to 2, and which end of it.
struct AxisEnd {
    int axis;
    bool positive;
};

/// Draws the axes as the camera sees them, at the lower left, with their names; the end that was clicked.
std::optional<AxisEnd> drawTriad(const Camera& camera, const std::array<std::string, 3>& names,
                                 const PictureArea& area);

}  // namespace mote::client
