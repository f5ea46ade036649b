// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobDatabase: jobs in one SQLite file, on the disk before a call returns. One owner, one thread; every call
// is one transaction.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/scene/error.h"
#include "server/jobs/job_record.h"

struct sqlite3;

namespace mote::server {

class JobDatabase {
  public:
    struct Content {
        std::vector<JobRecord> jobs;           ///< oldest first
        std::vector<std::int64_t> unreadable;  ///< numbers of rows that make no sense
        std::optional<Error> broken;           ///< why rows after these cannot be read
    };

    /// Opens or makes the file. Errors: corrupt (broken, or no database of jobs), permissionDenied,
    /// unsupported (a newer version's file), resourceExhausted, internal.
    static Result<JobDatabase> open(const std::filesystem::path& file);

    /// As much as can be read.
    Content load() const;
    /// Gives the record its number. Errors: internal, resourceExhausted (the disk).
    Status insert(JobRecord& record);
    /// Under its number, in the place of what was there. Errors: as insert.
    Status write(const JobRecord& record);
    Status remove(std::int64_t number);
    /// After rows were found damaged: what finds them is made from what they say now.
    Status indexAnew();
    /// Becomes what the other one is. Errors: as insert.
    Status copy(const JobDatabase& from);

  private:
    struct Close {
        void operator()(sqlite3* database) const;
    };
    using Handle = std::unique_ptr<sqlite3, Close>;

    explicit JobDatabase(Handle database) : database_(std::move(database)) {}

    Handle database_;
};

}  // namespace mote::server
