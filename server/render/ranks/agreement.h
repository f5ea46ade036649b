// SPDX-License-Identifier: GPL-3.0-or-later
//
// Agreement: how a picture goes on or ends on all ranks alike, though one of them fails or the picture is
// stopped. One a picture and rank; one thread.
#pragma once

#include <exception>
#include <optional>
#include <stop_token>
#include <vector>

#include "protocol/base/error.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {

class Agreement {
  public:
    explicit Agreement(Ranks& ranks) : ranks_(ranks) {}

    /// Does this rank's work, unless some of it failed before. What is thrown waits for all(); if there is no
    /// memory to keep that, the process ends.
    template <class Work>
    void attempt(Work work) {
        if (error_) return;
        try {
            work();
        } catch (const std::exception&) {
            keepHandled();
        }
    }

    /// All ranks call it: whether they go on. Not if one of them failed, or `stop` was requested on one.
    bool all(const std::stop_token& stop);
    /// What all() said latest.
    bool wentOn() const { return wentOn_; }
    /// All ranks call it: whether `pause` was requested on one.
    bool paused(const std::stop_token& pause);

    /// The first failure, naming its rank, on rank 0 once all() said no; nothing if it was a stop.
    const std::optional<Error>& failure() const { return error_; }

  private:
    void keepHandled() noexcept;
    std::vector<Bytes> exchangeErrors() const noexcept;
    void takeFirst(const std::vector<Bytes>& errors);

    Ranks& ranks_;
    std::optional<Error> error_;
    bool wentOn_ = true;
};

}  // namespace mote::render
