// SPDX-License-Identifier: GPL-3.0-or-later
//
// TimeBar: the steps of what is shown, in a bar below the picture: an axis of steps, iterations, time or
// position, going there, and playing. Main thread, within a Dear ImGui frame.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/connection.h"
#include "client/view/panel_widgets.h"
#include "client/view/view_model.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// When the next step of a series is shown: at a chosen rate, but not before the one of now was
/// seen, so that a slow server leaves none out. A value that knows no clock.
class Playback {
  public:
    bool playing = false;
    bool loop = true;  ///< else it ends at the last
    bool backwards = false;
    int stride = 1;  ///< steps at a time
    float stepsPerSecond = 10.0F;

    /// The step to show at `now` seconds. `seen`: a picture of `step` is on the screen.
    std::optional<std::uint32_t> next(double now, std::uint32_t step, int steps, bool seen) {
        if (!playing || !seen || steps < 2 || now < last_ + 1.0 / stepsPerSecond) return std::nullopt;
        last_ = now;
        const std::int64_t wanted = std::int64_t{step} + (backwards ? -stride : stride);
        if (wanted >= 0 && wanted < steps) return static_cast<std::uint32_t>(wanted);
        playing = loop;
        if (!loop) return std::nullopt;
        return backwards ? static_cast<std::uint32_t>(steps) - 1 : 0U;
    }

  private:
    double last_ = 0.0;  // seconds; when a step was last shown
};

/// A number that each step of a dataset has, by which all of them can be told apart: it ascends or descends.
struct TimeScale {
    std::string_view name;  ///< "iteration", "time", "position" (of the particles' mean along z)
    std::string_view unit;  ///< "s", "m"; "1": none
    std::vector<double> values;

    /// "t = 3.3 ns"
    std::string said(std::size_t step) const;
};

/// Those that a dataset says; none of one with fewer than two steps.
std::vector<TimeScale> timeScales(const proto::Manifest& manifest);

/// Which steps of a dataset the server has in memory: asked for as pictures come, and no more once nothing
/// changes.
class LoadedSteps {
  public:
    static constexpr double pause = 0.5;  ///< seconds between questions

    using Ask = std::function<void(const std::string& dataset, Connection::Reply<proto::Loaded>)>;

    /// Each frame of the window. `picture`: that is on the screen; null: none. `now`: seconds.
    void look(double now, const std::string& dataset, const proto::Frame* picture, const Ask& ask);
    /// The same over a connection, which outlives it; older servers (filesFromMinor) are not asked.
    void look(double now, const std::string& dataset, const proto::Frame* picture, Connection& connection);
    bool holds(std::uint32_t step) const;
    const std::vector<std::uint32_t>& steps() const { return steps_; }  ///< ascending

  private:
    std::string dataset_;
    std::vector<std::uint32_t> steps_;  // ascending
    std::uint64_t view_ = 0, sequence_ = 0;
    double askedAt_ = -std::numeric_limits<double>::infinity();
    bool due_ = false, waiting_ = false;
};

struct TimeBarPlace {
    float left, top, width, scale;  ///< screen coordinates; pixels to one of them
};

class TimeBar {
  public:
    static constexpr float height(float scale) { return 32.0F * scale; }  // a row with room around it
    /// `scales`: of the steps, or none.
    void draw(ViewModel& model, Playback& playback, const std::vector<TimeScale>& scales,
              const TimeBarPlace& place, PanelActions& actions);

    LoadedSteps loaded;  ///< of the dataset whose steps these are
    std::string scale;   ///< by which its ticks lie, if the steps have it; else they lie evenly

  private:
    static void drawButtons(const Playback& playback, float density, PanelActions& actions);
    void drawRow(ViewModel& model, Playback& playback, const std::vector<TimeScale>& scales, float density,
                 PanelActions& actions);
    void drawLoaded(int steps, const std::function<float(int)>& across, float bottom) const;
    void drawTrack(ViewModel& model, const TimeScale* chosen, float width, PanelActions& actions) const;
    void drawPlaying(Playback& playback, const std::vector<TimeScale>& scales, float density);
};

}  // namespace mote::client
