// SPDX-License-Identifier: GPL-3.0-or-later
//
// A RenderService is the one thread that owns the device, and knows what it draws for whom. Sessions tell it
// their latest view and their credits, from any thread and without waiting; it hands back encoded frames.
// Idle, it sleeps.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/data/picture_memory.h"
#include "server/data/step_source.h"
#include "server/encode/frame_encoder.h"
#include "server/frames/crash_record.h"
#include "server/frames/picture_maker.h"
#include "server/frames/render_schedule.h"
#include "server/frames/view_task.h"

namespace mote::server {

/// A picture on its way to its client. All of the message is filled in but what the sender knows: its
/// sequence and the total time.
struct RenderedFrame {
    proto::Frame message;
    std::vector<std::uint8_t> payload;
    Clock::time_point arrived;         ///< of the view
    bool quick = true;                 ///< of a hand in motion, or of a film: others like it follow
    bool canWait = false;              ///< a refinement: whatever is newer may overtake it between two pieces
    bool wanted = false;               ///< nevertheless it is sent to its end: a script waits for it
    PictureMemory::Taken memory = {};  ///< of the payload
};

/// Called on the service's threads, also shortly after close(); must not block. At most as many frames come
/// as there are credits.
struct RenderEvents {
    std::function<void(RenderedFrame)> frame;
    /// The view cannot be drawn; no credit is spent.
    std::function<void(const ViewTask& task, Error)> failed;
};

struct RenderSettings {
    double budgetMs = 30.0;                      ///< for a picture of a view in motion
    std::shared_ptr<PictureMemory> memory = {};  ///< that pictures are counted to; null: nobody counts
    unsigned encodeThreads = 2;
    ScheduleSettings schedule;
    CrashRecord* crashes = nullptr;  ///< outlives the service; null: nobody would read it
};

class RenderService {
  public:
    /// The factory is called, and `steps` asked, on the thread that renders; `steps` must outlive the
    /// service.
    RenderService(DeviceFactory factory, StepSource& steps, RenderSettings settings = {});
    /// Stops what is under way and waits for the threads.
    ~RenderService();
    RenderService(const RenderService&) = delete;
    RenderService& operator=(const RenderService&) = delete;

    /// Waits for the device; returns its name. Once. Errors: internal (there is no such device).
    Result<std::string> start();

    /// `background`: its pictures are made while nobody else wants one, and are stopped for others'.
    void open(SessionId session, std::uint32_t credits, RenderEvents events, bool background = false);
    void close(SessionId session);
    /// Errors: as RenderSchedule::setView.
    Status setView(SessionId session, std::shared_ptr<const ViewTask> task);
    /// What the session's link and client ask of its next pictures; before the first call: of an unmeasured
    /// one.
    void setTarget(SessionId session, const EncodingTarget& target);
    /// The client could not decode a frame of its stream.
    void wantKey(SessionId session);
    void addCredits(SessionId session, std::uint32_t count);
    /// More of the data is in memory, or never will be: pictures that wait for it are tried again.
    void dataArrived();
    /// When the device failed, if it has drawn no picture since. From any thread.
    std::optional<Clock::time_point> deviceFailed() const;

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace mote::server
