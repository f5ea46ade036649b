// SPDX-License-Identifier: GPL-3.0-or-later
//
// FirstError: what went wrong first on any of several threads. set() may be called from any thread.
#pragma once

#include <mutex>

#include "protocol/scene/error.h"

namespace mote::prep {

class FirstError {
  public:
    void set(const Error& error) {
        const std::lock_guard lock(mutex_);
        if (status_.ok()) status_ = error;
    }
    /// Once the others are done.
    const Status& status() const { return status_; }

  private:
    std::mutex mutex_;
    Status status_ = success();
};

}  // namespace mote::prep
