// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmStrip: the keyframes of a film as pictures along a line of time, with the playhead. A picture is
// dragged in time; elsewhere the mouse moves the playhead. Main thread, inside a Dear ImGui window.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "client/view/film/film_model.h"

namespace mote::client {

/// Where a time lies on the strip of keyframes. A value; pure functions.
struct StripScale {
    double begin = 0.0, end = 1.0;    ///< seconds; begin < end
    float left = 0.0F, width = 1.0F;  ///< pixels

    /// Shows a film and a piece after it, which keyframes are dragged into. `margin` pixels stay free on both
    /// sides.
    static StripScale of(double begin, double end, float left, float width, float margin) {
        const double first = std::min(begin, 0.0);
        const double last = std::max(first + 5.0, end + 0.15 * (end - first));
        return {first, last, left + margin, std::max(width - 2.0F * margin, 1.0F)};
    }

    float at(double seconds) const {
        return left + static_cast<float>((seconds - begin) / (end - begin) * static_cast<double>(width));
    }
    /// Times off the strip are its ends'.
    double from(float x) const {
        const double share = std::clamp(static_cast<double>((x - left) / width), 0.0, 1.0);
        return begin + share * (end - begin);
    }

    /// Seconds between marks: 1, 2 or 5 times a power of ten, at least so many pixels apart.
    double markSpacing(float pixels) const {
        const double least = (end - begin) * static_cast<double>(pixels / width);
        const double power = std::pow(10.0, std::floor(std::log10(least)));
        for (const double factor : {1.0, 2.0, 5.0})
            if (factor * power >= least) return factor * power;
        return 10.0 * power;
    }
};

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
