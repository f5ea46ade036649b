// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureTool: what the mouse does on the picture in place of turning it: it draws a lasso, or picks a point.
// A value that knows no window; places are parts of the picture's width and height, y down.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <vector>

namespace mote::client {

class PictureTool {
  public:
    enum class Kind { none, lasso, pick };
    struct Mouse {
        glm::dvec2 at;         ///< a part of the picture
        glm::dvec2 pixel;      ///< the size of a screen pixel, likewise
        bool pressed = false;  ///< in this frame, on the picture
        bool held = false;
        bool picks = false;  ///< a key is held that makes a click a pick
    };
    /// What the hand has finished in this frame.
    struct Done {
        std::vector<glm::dvec2> lasso = {};  ///< empty: none
        std::optional<glm::dvec2> pick = {};
    };

    Kind kind() const { return kind_; }
    /// A lasso under way is given up.
    void setKind(Kind kind);
    void toggle(Kind kind) { setKind(kind == kind_ ? Kind::none : kind); }

    /// The mouse is the tool's and not the camera's.
    bool takes(const Mouse& mouse) const { return kind_ != Kind::none || drawing_ || mouse.picks; }
    Done move(const Mouse& mouse);
    /// The open line of a lasso under way.
    const std::vector<glm::dvec2>& line() const { return line_; }
    bool drawing() const { return drawing_; }

  private:
    void extend(const Mouse& mouse);

    Kind kind_ = Kind::none;
    bool drawing_ = false;
    std::vector<glm::dvec2> line_;
};

}  // namespace mote::client
