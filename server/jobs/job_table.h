// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobTable: all jobs in memory, each change of state written through to the store. Owned by the queue and
// used on its thread. What the store cannot take (a full disk) is remembered as unsaved and tried again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/job_store.h"

namespace mote::server {

class JobTable {
  public:
    explicit JobTable(JobStore store) : store_(std::move(store)) {}

    /// What is stored takes the place of all that was known. Errors: as JobStore::load; nothing has changed
    /// then.
    Status load();
    /// Gives it a number. The pointer stays valid until prune() forgets a finished job. Errors: as
    /// JobStore::insert.
    Result<JobRecord*> add(JobRecord record);
    /// Errors: as JobStore::update; it is one of unsaved() then.
    Status save(const JobRecord& record);
    /// Numbers of jobs whose last change the disk does not know.
    const std::set<std::int64_t>& unsaved() const { return unsaved_; }
    /// Forgets the oldest finished jobs beyond `kept`; returns them.
    std::vector<JobRecord> prune(std::size_t kept);

    JobRecord* find(std::string_view id);
    const JobRecord* find(std::string_view id) const;
    JobRecord* find(std::int64_t number);
    /// The films, or the other jobs, that wait, as they are to begin: clients take turns, each with its jobs
    /// in the order of submission. First comes who has the fewest that run, then whose last one began first.
    std::vector<JobRecord*> queued(bool film);
    std::size_t count(proto::JobStatus::State state) const;
    /// How many of a client's jobs wait.
    std::size_t waiting(const std::string& client) const;
    /// All jobs, in the order of submission.
    std::vector<JobRecord*> all();
    /// A live job with this output; null: none.
    const JobRecord* maker(std::string_view output) const;
    /// What runs, then what waits, then what has ended (with the last five lines of their logs), the newest
    /// first of each; at most `most` in all.
    std::vector<proto::JobStatus> list(std::size_t most) const;
    /// `count` of all jobs, the latest first, from the one of this place on; logs as of list().
    std::vector<proto::JobStatus> page(std::uint64_t first, std::size_t count) const;
    std::size_t size() const { return records_.size(); }
    /// The latest of those with this digest, which is not empty, that is `wanted`; null: none.
    const JobRecord* latest(const std::string& digest,
                            const std::function<bool(const JobRecord&)>& wanted) const;

  private:
    JobStore store_;
    std::map<std::int64_t, JobRecord> records_;  // by number
    std::set<std::int64_t> unsaved_;
};

}  // namespace mote::server
