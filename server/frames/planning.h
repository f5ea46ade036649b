// SPDX-License-Identifier: GPL-3.0-or-later
//
// Planning: a draft on its way, where what comes before the device draws takes long. It gives way to others'
// pictures, and then nobody looks at what it works with. Of the thread that renders.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "protocol/base/error.h"
#include "server/data/step_source.h"
#include "server/frames/picture_history.h"
#include "server/frames/picture_maker.h"
#include "server/frames/render_schedule.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::server {

/// A clock that stands still while others' pictures go before what this thread plans.
inline Clock::time_point workClock() {
    return Clock::now() - render::timeOfOthers();
}

/// Bytes that a job's picture takes at most until it is encoded, of a view with that size and those layers;
/// what data take apart.
std::uint64_t pictureBytes(const View& view, const RenderJob& job, StepSource& data);
/// That one takes which is done, while it is encoded. `page`: as a document.
std::uint64_t encodingBytes(const render::Picture& picture, bool annotated, bool page);

/// Whether a job's picture may have to wait, and its plan may take long: a quick one is never paused.
bool isPlannedInTurns(const RenderJob& job);

class Planning {
  public:
    /// With a history of its own.
    using Make = std::function<Result<std::unique_ptr<Draft>>(PictureHistory& history, Making& why)>;

    /// Nothing is made yet.
    Planning(const RenderJob& job, const PictureHistory& history, Make make,
             render::WorkInTurns::Duration leastTurn);

    /// As WorkInTurns.
    bool advance(const std::stop_token& pause) { return work_.advance(pause); }
    /// What it made, once it is done, with what it left of the history.
    Result<std::unique_ptr<Draft>> take(PictureHistory& history, Making& why);

  private:
    PictureHistory history_;
    Making why_;
    Result<std::unique_ptr<Draft>> draft_ = std::unique_ptr<Draft>();
    render::WorkInTurns work_;  // goes first: it uses the others
};

}  // namespace mote::server
