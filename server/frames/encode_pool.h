// SPDX-License-Identifier: GPL-3.0-or-later
//
// An EncodePool is a few threads that encode pictures while the next ones are rendered. Work of one session
// is done in order and never at the same time. Work of background sessions has a thread of its own, of a
// lower priority. Any thread may post; destroying it waits for what is under way and drops the rest.
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

    /// Nothing is dropped but by destruction: callers post no more than they have credits for. `work` must
    /// not throw. `background`: the same for all of a session.
    void post(SessionId session, std::function<void()> work, bool background = false);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace mote::server
