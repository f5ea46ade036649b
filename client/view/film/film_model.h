// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmModel: the film that is edited in the viewer: keyframes, which of them is selected, and the playhead.
// Its keyframes ascend in time by at least a frame; with two of them its script is a valid one. A value that
// knows no window and no clock; main thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/film/check_script.h"
#include "protocol/scene/film/easing.h"
#include "protocol/scene/film/steps_between.h"

namespace mote::client {

struct FilmKeyframe {
    double seconds = 0.0;
    proto::View view;  ///< valid; its size is the film's
    Easing easing = Easing::linear;
    std::uint64_t picture = 0;  ///< number of its thumbnail; copies have the same
};

struct FilmSize {
    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels

    bool operator==(const FilmSize&) const = default;
};

class FilmModel {
  public:
    /// Seconds from the last keyframe to one that is put behind it.
    static constexpr double usualGap = 2.0;

    /// The film of a script of keyframes. Keyframes nearer to each other than a frame are moved apart.
    /// Errors: of checkScript(); unsupported: a script of views or moves.
    static Result<FilmModel> fromScript(const proto::Script& script);
    /// Returns, with two keyframes, a script that checkScript() finds nothing wrong with. Without easings
    /// where the speed is constant.
    proto::Script toScript() const;
    /// What "save" writes: a script that was read as it was, but for what the user has changed; else
    /// toScript().
    proto::Script saved() const;

    const std::vector<FilmKeyframe>& keyframes() const { return keyframes_; }
    bool empty() const { return keyframes_.empty(); }
    bool isFilm() const { return keyframes_.size() >= 2; }
    double begin() const { return empty() ? 0.0 : keyframes_.front().seconds; }  ///< seconds
    double end() const { return empty() ? 0.0 : keyframes_.back().seconds; }     ///< seconds
    /// Frames, both ends shown; 0 of what is no film yet.
    std::uint64_t frameCount() const;
    /// Another number after every change of what is shown, in all films; a copy has the same.
    std::uint64_t revision() const { return revision_; }

    /// Puts a valid view at the playhead where that lies between two keyframes with a frame's room, else
    /// after the last. It is selected; the first one decides the film's size, made even. Errors:
    /// invalidArgument (of parseView), resourceExhausted: there is no room for it.
    Status add(const proto::View& view);
    /// A copy of the selected one half way to the next, or after the last. Errors: as add().
    Status duplicate();
    /// The selected one shows another view from now on. Errors: as parseView(); nothing is selected.
    Status replace(const proto::View& view);
    void removeSelected();
    /// Moves it to a time of a whole frame, but never past a neighbour, and no film longer than it may be.
    /// `keyframe` is one of keyframes().
    void move(std::size_t keyframe, double seconds);
    /// Of the selected one.
    void setEasing(Easing easing);

    std::optional<std::size_t> selected() const { return selected_; }
    /// Takes the playhead along. One of keyframes().
    void select(std::size_t keyframe);
    double playhead() const { return playhead_; }  ///< seconds; within the film
    void setPlayhead(double seconds);

    double fps() const { return fps_; }  ///< frames a second
    /// Sets it as near as the film allows; keyframes that come too near move apart.
    void setFps(double fps);
    FilmSize size() const { return size_; }
    /// Sets the size of all frames. Ignored if a view cannot have it.
    void setSize(FilmSize size);
    bool constantSpeed() const { return constantSpeed_; }
    void setConstantSpeed(bool constant);
    BetweenSteps betweenSteps() const { return betweenSteps_; }
    void setBetweenSteps(BetweenSteps between);

  private:
    double frame() const { return 1.0 / fps_; }  // seconds
    /// The time of a whole frame, within limits.
    double whole(double seconds, double low, double high) const;
    /// The latest time that a keyframe may have.
    double latest() const;
    double earliest() const;
    std::optional<std::size_t> wayOfPlayhead() const;
    Status insert(std::size_t index, FilmKeyframe keyframe);
    void spread();
    void changed();

    proto::Script read_;    // as it was; empty if none was
    proto::Script before_;  // what toScript() made of it then
    std::vector<FilmKeyframe> keyframes_;
    std::optional<std::size_t> selected_;
    double playhead_ = 0.0;
    double fps_ = defaultFps;
    FilmSize size_;
    bool constantSpeed_ = false;
    BetweenSteps betweenSteps_ = BetweenSteps::hold;
    std::uint64_t pictures_ = 0;  // numbers given so far
    std::uint64_t revision_ = 0;
};

/// Which time of a film is shown while it is played in real time: that of the frame that is due,
/// so that a slow server leaves frames out and never makes it late. A value that knows no clock.
class FilmPreview {
  public:
    bool loop = true;

    bool playing() const { return playing_; }
    /// Shows, at `now` seconds, the film from `seconds` on; from its begin where that is its end.
    void start(double now, double seconds, double begin, double end) {
        const double from = seconds < end ? std::max(seconds, begin) : begin;
        playing_ = end > begin;
        origin_ = now - (from - begin);
        shown_.reset();
    }
    void stop() { playing_ = false; }

    /// The time of the frame that is due at `now`, where it is another than before. Stops with the last frame
    /// unless it loops.
    std::optional<double> next(double now, double begin, double end, double fps) {
        if (!playing_) return std::nullopt;
        double passed = std::max(now - origin_, 0.0);
        const double length = end - begin;
        if (!(length > 0.0)) {
            stop();
            return std::nullopt;
        }
        if (passed >= length && !loop) {
            stop();
            return end;
        }
        passed = std::fmod(passed, length + 1.0 / fps);  // the last frame is seen as long as the others
        const double due = std::min(begin + std::floor(passed * fps) / fps, end);
        if (shown_ == due) return std::nullopt;
        shown_ = due;
        return due;
    }

  private:
    bool playing_ = false;
    double origin_ = 0.0;          // seconds; when the film began
    std::optional<double> shown_;  // seconds of the film
};

}  // namespace mote::client
