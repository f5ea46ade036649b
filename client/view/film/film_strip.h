// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmStrip: the keyframes of a film as pictures along a line of time, with the playhead. A picture is
// dragged in time; elsewhere the mouse moves the playhead. Main thread, inside a Dear ImGui window.
#pragma once

#include <functional>
#include <optional>

#include "client/view/film/film_model.h"
#include "client/view/film/strip_scale.h"

namespace mote::client {

/// What Dear ImGui calls the thumbnail of a number; null while there is none.
using ThumbnailHandles = std::function<void*(std::uint64_t picture)>;

class FilmStrip {
  public:
    enum class Touch { none, selected, scrubbed, moved };

    /// Draws it over the width that is left, `height` pixels high. Moves keyframes and playhead of the model;
    /// says what the mouse did in this frame.
    Touch draw(FilmModel& model, const ThumbnailHandles& thumbnails, float height, float scale);
    /// The mouse holds a keyframe or the playhead.
    bool held() const { return held_; }

  private:
    struct Box {
        float left, top, right, bottom;  // pixels

        bool holds(float x, float y) const { return x >= left && x < right && y >= top && y < bottom; }
    };

    Box boxOf(const FilmModel& model, std::size_t keyframe) const;
    std::optional<std::size_t> keyframeAt(const FilmModel& model, float x, float y) const;
    Touch takeMouse(FilmModel& model);
    Touch press(FilmModel& model, float x, float y);
    Touch drag(FilmModel& model, float x);
    void drawRuler(float scale) const;
    void drawWays(const FilmModel& model, float scale) const;
    void drawKeyframe(const FilmModel& model, std::size_t keyframe, void* thumbnail, float scale) const;
    void drawPlayhead(const FilmModel& model, float scale) const;

    StripScale scale_;  // stays while the mouse holds something
    Box area_{};        // of it all
    float pictureHeight_ = 0.0F, pictureWidth_ = 0.0F;
    bool held_ = false;
    std::optional<std::size_t> keyframe_;  // that is dragged; none: the playhead
    bool dragged_ = false;                 // it has left the place where it was pressed
    float pressedAt_ = 0.0F, grip_ = 0.0F;
};

}  // namespace mote::client
