// SPDX-License-Identifier: GPL-3.0-or-later
//
// Notes: what the viewer has to say, on the picture: news that stay until they are put away, and what is
// wrong with what is shown, with what can be done about it. Main thread, within a Dear ImGui frame.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
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

/// Where a picture lies on the screen.
struct PictureArea {
    float width, height;                  ///< screen coordinates
    float scale;                          ///< pixels to one of them
    float left = 0.0F, top = 0.0F;        ///< of its upper left corner
    std::uint32_t columns = 0, rows = 0;  ///< pixels of its view

    double aspect() const { return static_cast<double>(columns) / rows; }
    /// A place on the screen as parts of its width and height.
    glm::dvec2 partAt(double x, double y) const { return {(x - left) / width, (y - top) / height}; }
    bool holds(double x, double y) const {
        return x >= left && x < left + width && y >= top && y < top + height;
    }
};

class Notes {
  public:
    /// News are said once as long as they stand there; the oldest go where there are too many.
    void add(Note note);
    void clear(const std::string& sentence);
    /// Draws news at the lower right; what the user chose is done after that.
    void draw(const PictureArea& area);

  private:
    static constexpr std::size_t most = 5;
    std::vector<Note> news_;
};

/// Draws what is wrong in the middle above, in a window of this name; what the user chose is done after that.
void drawWrong(const char* name, const PictureArea& area, const std::vector<Note>& wrong);

/// Draws below the middle what is being made, and how far that is, 0 to 1; true: the user wants none of it.
bool drawMaking(const PictureArea& area, const std::string& what, double progress, const std::string& phase);

/// Draws above the picture what the hand does in place of turning it.
void drawSign(const PictureArea& area, const std::string& said);

/// Draws in the lower right corner of the picture what holds for all of it.
void drawFootnote(const PictureArea& area, const std::string& said);

/// A side of what is shown: an axis, 0 to 2, and which end of it.
struct AxisEnd {
    int axis;
    bool positive;
};

/// Draws the axes as the camera sees them, at the lower left, with their names; the end that was clicked.
std::optional<AxisEnd> drawTriad(const Camera& camera, const std::array<std::string, 3>& names,
                                 const PictureArea& area);

}  // namespace mote::client
