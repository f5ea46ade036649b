// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobTable: all jobs in memory, each change written through to the store. Owned by the queue and used on its
// thread. A store that fails (a full disk) is said in the log: the jobs of this server go on from memory.
#pragma once

#include <cstddef>
#include <map>
#include <string_view>
#include <vector>

#include "server/jobs/job_record.h"
#include "server/jobs/job_store.h"

namespace mote::server {

class JobTable {
  public:
    explicit JobTable(JobStore store) : store_(std::move(store)) {}

    /// Errors: as JobStore::load.
    Status load();
    /// Gives it a number. The pointer stays valid until prune() forgets a finished job. Errors: as
    /// JobStore::insert.
    Result<JobRecord*> add(JobRecord record);
    void save(const JobRecord& record);
    /// Forgets the oldest finished jobs beyond `kept`.
    void prune(std::size_t kept);

    JobRecord* find(std::string_view id);
    const JobRecord* find(std::string_view id) const;
    JobRecord* find(std::int64_t number);
    /// The one that has waited longest; null: none waits.
    JobRecord* nextQueued();
    std::size_t count(proto::JobStatus::State state) const;
    /// All jobs, in the order of submission.
    std::vector<JobRecord*> all();
    /// A live job with this output; null: none.
    const JobRecord* maker(std::string_view output) const;
    /// Newest first: live ones, then finished ones (with the last five lines of their logs), at most `most`
    /// in all.
    std::vector<proto::JobStatus> list(std::size_t most) const;

  private:
    JobStore store_;
    std::map<std::int64_t, JobRecord> records_;  // by number
};

}  // namespace mote::server
