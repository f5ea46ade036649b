// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobStore: the jobs of a server on the disk, twice: where one file is damaged, the other one knows them.
// Owned by the queue and used on its thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/scene/error.h"
#include "server/jobs/job_database.h"

namespace mote::server {

class JobStore {
  public:
    /// "jobs.sqlite" gives "jobs.copy.sqlite".
    static std::filesystem::path copyOf(const std::filesystem::path& file);

    /// Opens or makes the file and its copy. One that is no job database, or a broken one, is moved aside
    /// (FILE.broken-N), made anew from the other one, and `setAside` says where. Errors: permissionDenied,
    /// unsupported (a newer version's file), internal.
    static Result<JobStore> open(const std::filesystem::path& file);

    /// All jobs, oldest first; rows that make no sense in either file are left out and said in the log.
    /// Errors: internal, corrupt.
    Result<std::vector<JobRecord>> load();
    /// Gives the record its number. Errors: internal, resourceExhausted (the disk).
    Status insert(JobRecord& record);
    Status update(const JobRecord& record);
    Status remove(std::int64_t number);

    const std::filesystem::path& setAside() const { return setAside_; }

  private:
    JobStore(JobDatabase database, JobDatabase copy)
        : database_(std::move(database)), copy_(std::move(copy)) {}
    void follow(Status copied);

    JobDatabase database_, copy_;
    bool copyIsBehind_ = true;  ///< it lacks a change, and is made anew with the next one
    std::filesystem::path setAside_;
};

}  // namespace mote::server
