// SPDX-License-Identifier: GPL-3.0-or-later
//
// A RenderSchedule decides which session's picture is rendered next, and at which stage. It knows neither
// threads nor devices nor clocks: its owner locks it, tells it the time and does what it says.
//
// - A session has one view, the latest; a newer one replaces it. A queued one lets those before it stay and
//   is drawn when they are done with: views of a film.
// - A frame takes a credit; without one, nothing is rendered for that session.
// - Sessions take turns, by the time that their pictures took: whoever had least of it goes first. Quick
//   pictures go before refinements, until a refinement has waited longer than `patience`: then it takes its
//   turn among the quick ones.
// - A refinement is paused as soon as anybody else has a picture to be drawn, and goes on from there at its
//   next turn. A quick picture stops one that has not waited long even where that loses what was done for it.
// - A newer view stops the refinement of the older one. A quick picture is never stopped: a hand that moves
//   faster than pictures are rendered would see none.
// - Background sessions are served while nobody else has a picture to be drawn, and has had none for a
//   moment, nor moves a view; whatever others want drawn stops theirs. They take turns among themselves, and
//   no waiting makes them urgent.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>

#include "protocol/base/error.h"
#include "server/frames/view_task.h"

namespace mote::server {

/// What a view's next picture is. A view that only wants the exact one starts there.
enum class Stage { quick, intermediate, exact, done };

struct ScheduleSettings {
    Clock::duration restDelay = std::chrono::milliseconds(40);  ///< a view so old is at rest: about a frame
    Clock::duration patience = std::chrono::seconds(2);         ///< a refinement waits no longer for others
    Clock::duration backgroundDelay = std::chrono::milliseconds(40);  ///< after the others' latest picture
    /// After the others' latest view in motion: a hand whose pictures come late has put it down by then.
    Clock::duration handDelay = std::chrono::seconds(1);
};

/// One of the pictures that a picture between steps is the mean of (server/frames/mean_picture.h). It is made
/// in linear light.
struct PicturePart {
    double place = 0.0;                          ///< as viewAt()
    std::optional<double> resolutionScale = {};  ///< of those before it, which it must have too
};

/// One picture to render.
struct RenderJob {
    SessionId session = 0;
    std::shared_ptr<const ViewTask> task;
    Stage stage = Stage::quick;
    std::stop_token stop = {};   ///< it is to end, whatever is lost
    std::stop_token pause = {};  ///< it is to give way and keep what is done; requested wherever `stop` is
    std::optional<PicturePart> part = {};  ///< null: the whole picture
};

class RenderSchedule {
  public:
    explicit RenderSchedule(ScheduleSettings settings = {}) : settings_(settings) {}

    void open(SessionId session, std::uint32_t credits, bool background = false);
    /// Forgets a session; stops its picture if that is under way.
    void close(SessionId session);
    /// Unknown sessions are ignored, here and below: they closed meanwhile.
    /// Errors: resourceExhausted where a queued view is one more than wire::maxQueuedViews that are not drawn
    /// yet; nothing has changed then.
    Status setView(SessionId session, std::shared_ptr<const ViewTask> task);
    void addCredits(SessionId session, std::uint32_t count);

    /// Takes the next picture and a credit for it. Only one may be under way at a time: finish it first.
    std::optional<RenderJob> next(Clock::time_point now);
    /// When next() may have something although nothing else happened; nothing: never.
    std::optional<Clock::time_point> nextDue() const;
    /// Whether the job's view is still the one that its session wants.
    bool current(const RenderJob& job) const;

    /// What the device worked for the picture under way: before it is finished.
    void charge(const RenderJob& job, Clock::duration took);
    /// The job's picture goes out; its view, if still wanted, is at `next` now.
    void finishDrawn(const RenderJob& job, Stage next);
    /// It was stopped or paused, or nobody wants it: the credit comes back, the stage stays.
    void finishStopped(const RenderJob& job);
    /// It waits for data or memory: the credit comes back, and it is tried again when some arrived, or at
    /// `until`.
    void finishWaiting(const RenderJob& job, std::optional<Clock::time_point> until = {});
    /// Data arrived that somebody may wait for.
    void dataArrived(Clock::time_point now);
    /// It cannot be drawn: the credit comes back, and nothing more is tried for this view.
    void finishFailed(const RenderJob& job);

  private:
    struct Client {
        std::shared_ptr<const ViewTask> task;
        std::deque<std::shared_ptr<const ViewTask>> queue = {};  ///< after it
        Stage stage = Stage::done;
        std::uint32_t credits = 0;
        bool background = false;
        std::uint64_t served = 0;  ///< the turn in which it was served last
        Clock::duration used{0};   ///< of the device's time; who was idle has used what others had then
        Clock::time_point due;     ///< the stage may begin
        bool waits = false;        ///< for data or memory: it may not
        std::optional<Clock::time_point> until = {};  ///< then it may again
        bool fresh = false;  ///< its turn came since the latest next(): due then at the earliest

        bool open() const { return stage != Stage::done && credits > 0 && !waits; }
    };
    using Clients = std::map<SessionId, Client>;
    struct Running {
        SessionId session;
        std::shared_ptr<const ViewTask> task;
        Stage stage;
        bool background;
        bool patient;  ///< nothing of it may be lost to others' quick pictures
        std::stop_source stop, pause;
    };

    bool urgent(const Client& client, Clock::time_point now) const;
    /// Somebody who is no background session has a picture to be drawn, now or soon.
    bool foregroundOpen() const;
    /// When background sessions may be served, if nobody else has a picture to be drawn until then.
    Clock::time_point backgroundDue() const;
    Clients::value_type* choose(Clock::time_point now, bool background);
    bool contends(const Client& client, const Client& chosen, Clock::time_point now) const;
    void enter(Client& client, Stage stage);
    void begin(Client& client, std::shared_ptr<const ViewTask> task);
    void finish(const RenderJob& job, bool returnCredit, std::optional<Stage> stage);
    /// Stops or pauses what runs where something better came up.
    void reconsider();
    bool stopsRunning(const Client& client) const;
    bool pausesRunning(const Clients::value_type& entry) const;
    void stopRunning();

    ScheduleSettings settings_;
    Clients clients_;
    std::optional<Running> running_;
    std::uint64_t turn_ = 0;
    Clock::duration usedLeast_{0};  // by whoever had its turn latest, before it
    Clock::time_point now_;         // as it was told latest
    bool busy_ = false;             // with others than background sessions
    Clock::time_point quietSince_;  // when that was seen to have ended
};

}  // namespace mote::server
