// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobRecord: what is remembered of a job: what clients see, and what a restarted server needs. A value.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/mote.pb.h"

namespace mote::server {

struct JobRecord {
    std::int64_t number = 0;  ///< order of submission, given by the store
    proto::JobStatus status;
    int attempts = 0;              ///< how often it was started
    bool cancelRequested = false;  ///< its end, whatever it is, means cancelled (but for a published output)
    std::string handle;            ///< what its runner finds the running job by; empty: it never began
};

inline bool isLive(const JobRecord& record) {
    return record.status.state() == proto::JobStatus::QUEUED ||
           record.status.state() == proto::JobStatus::RUNNING;
}

}  // namespace mote::server
