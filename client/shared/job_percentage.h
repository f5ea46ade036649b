// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobPercentage: how far a job is, as one line of stderr that is written over, where that is a terminal; it
// goes with its object. One thread.
#pragma once

#include <string>

#include "protocol/mote.pb.h"

namespace mote::client {

class JobPercentage {
  public:
    /// `what` stands before the number. Shows nothing where it is not wanted.
    JobPercentage(std::string what, bool wanted);
    ~JobPercentage();
    JobPercentage(const JobPercentage&) = delete;
    JobPercentage& operator=(const JobPercentage&) = delete;

    void show(const proto::JobStatus& job);

  private:
    const std::string what_;
    const bool visible_;
    bool shown_ = false;
};

}  // namespace mote::client
