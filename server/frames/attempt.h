// SPDX-License-Identifier: GPL-3.0-or-later
//
// Attempt: what a picture makes of its session's dots and ink, undone where it comes to nothing. It lives
// while the picture is made.
#pragma once

#include <optional>
#include <utility>

#include "server/frames/dot_maker.h"
#include "server/frames/picture_history.h"
#include "server/frames/view_task.h"

namespace mote::server {

/// A picture that is stopped or waits is made again. Where it is one of a row that shall always be the same,
/// it then finds what it found: ink that follows the picture before must not follow one that was not
/// finished.
class Attempt {
  public:
    Attempt(const ViewTask& task, DotHistory& history) : history_(history) {
        if (task.finalOnly) before_ = copyOf(history);
    }
    ~Attempt() {
        if (before_) history_ = *std::move(before_);
    }
    Attempt(const Attempt&) = delete;
    Attempt& operator=(const Attempt&) = delete;

    void succeeded() { before_.reset(); }
    /// What it made of the history is kept for when it goes on.
    void paused(Draft& draft) {
        if (before_) draft.after = std::move(history_);
    }

  private:
    DotHistory& history_;
    std::optional<DotHistory> before_;
};

}  // namespace mote::server
