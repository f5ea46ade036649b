// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobRecord: what is remembered of a job: what clients see, and what a restarted server needs. A value.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/mote.pb.h"
#include "protocol/scene/job_request.h"

namespace mote::server {

struct JobRecord {
    std::int64_t number = 0;  ///< order of submission, given by the store
    proto::JobStatus status;
    int attempts = 0;              ///< how often it was started
    bool cancelRequested = false;  ///< its end, whatever it is, means cancelled (but for a published output)
    std::string handle;            ///< what its runner finds the running job by; empty: it never began
    std::string digest;            ///< of the request and what it reads (requestDigest); empty: not known
    std::string client;            ///< who submitted it, to this server; not stored
    std::string made;              ///< which file or folder it made (outputIdentity); empty: none
};

/// 16 hexadecimal digits, in small letters: what may be the name of a job's folder.
inline bool isJobId(std::string_view id) {
    return id.size() == 16 && id.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

inline bool isFilm(const JobRecord& record) {
    return record.status.request().has_film();
}

/// A film or an export.
inline bool keepsFiles(const JobRecord& record) {
    return staysWithJob(record.status.request());
}

/// What it made can be fetched.
inline bool hasFiles(const JobRecord& record) {
    return keepsFiles(record) && record.status.state() == proto::JobStatus::SUCCEEDED;
}

inline bool isLive(const JobRecord& record) {
    return record.status.state() == proto::JobStatus::QUEUED ||
           record.status.state() == proto::JobStatus::RUNNING;
}

}  // namespace mote::server
