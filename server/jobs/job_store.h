// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobStore: the jobs of a server in one SQLite file. Owned by the queue and used on its thread; every call is
// one transaction.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "protocol/scene/error.h"
#include "server/jobs/job_record.h"

struct sqlite3;

namespace mote::server {

class JobStore {
  public:
    /// Opens or makes the file. One that is no job database, or a broken one, is moved aside (FILE.broken-N)
    /// and `setAside` says where. Errors: permissionDenied, unsupported (a newer version's file), internal.
    static Result<JobStore> open(const std::filesystem::path& file);

    /// All jobs, oldest first; rows that make no sense are left out and said in the log. Errors: internal,
    /// corrupt.
    Result<std::vector<JobRecord>> load() const;
    /// Gives the record its number. Errors: internal, resourceExhausted (the disk).
    Status insert(JobRecord& record);
    Status update(const JobRecord& record);
    Status remove(std::int64_t number);

    const std::filesystem::path& setAside() const { return setAside_; }

  private:
    struct Close {
        void operator()(sqlite3* database) const;
    };
    using Database = std::unique_ptr<sqlite3, Close>;

    explicit JobStore(Database database) : database_(std::move(database)) {}
    static Result<Database> connect(const std::filesystem::path& file);

    Database database_;
    std::filesystem::path setAside_;
};

}  // namespace mote::server
