// SPDX-License-Identifier: GPL-3.0-or-later
//
// An EncodePool is a few threads that encode pictures while the next ones are rendered. Work of one session
// is done in order and never at the same time. What takes long, or may take its time, has a thread of its
// own, of a lower priority, so that nobody else's pictures wait for it. Any thread may post; destroying it
// waits for what is under way and drops the rest.
#pragma once

#include <functional>
#include <memory>

#include "server/frames/view_task.h"

namespace mote::server {

class EncodePool {
  public:
    explicit EncodePool(unsigned threads);
    ~EncodePool();
    EncodePool(const EncodePool&) = delete;
    EncodePool& operator=(const EncodePool&) = delete;

    enum class Pace {
        quick,
        slow,  ///< of a large picture, or for a session in the background
    };

    /// Nothing is dropped but by destruction: callers post no more than they have credits for. `work` must
    /// not throw.
    void post(SessionId session, std::function<void()> work, Pace pace = Pace::quick);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace mote::server
