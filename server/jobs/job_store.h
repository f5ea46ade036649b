// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobStore: the jobs of a server in one SQLite file. Owned by the queue and used on its thread; every call is
// one transaction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

struct sqlite3;

namespace mote::server {

/// JobRecord: what is remembered of a job: what clients see, and what a restarted server needs. A value.
struct JobRecord {
    std::int64_t number = 0;  ///< order of submission, given by the store
    proto::JobStatus status;
    int attempts = 0;              ///< how often it was started
    bool cancelRequested = false;  ///< its end, whatever it is, means cancelled (but for a published output)
    std::string handle;            ///< what its runner finds the running job by; empty: it never began
};

/// 16 hexadecimal digits, in small letters: what may be the name of a job's folder.
inline bool isJobId(std::string_view id) {
    return id.size() == 16 && id.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

inline bool isFilm(const JobRecord& record) {
    return record.status.request().has_film();
}

/// Its film can be fetched.
inline bool keepsFilm(const JobRecord& record) {
    return isFilm(record) && record.status.state() == proto::JobStatus::SUCCEEDED;
}

inline bool isLive(const JobRecord& record) {
    return record.status.state() == proto::JobStatus::QUEUED ||
           record.status.state() == proto::JobStatus::RUNNING;
}

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

/// JobTable: all jobs in memory, each change written through to the store. Owned by the queue and used on its
/// thread. A store that fails (a full disk) is said in the log: the jobs of this server go on from memory.
class JobTable {
  public:
    explicit JobTable(JobStore store) : store_(std::move(store)) {}

    /// Errors: as JobStore::load.
    Status load();
    /// Gives it a number. The pointer stays valid until prune() forgets a finished job. Errors: as
    /// JobStore::insert.
    Result<JobRecord*> add(JobRecord record);
    void save(const JobRecord& record);
    /// Forgets the oldest finished jobs beyond `kept`; returns them.
    std::vector<JobRecord> prune(std::size_t kept);

    JobRecord* find(std::string_view id);
    const JobRecord* find(std::string_view id) const;
    JobRecord* find(std::int64_t number);
    /// The film, or the other job, that has waited longest; null: none waits.
    JobRecord* nextQueued(bool film);
    std::size_t count(proto::JobStatus::State state) const;
    /// All jobs, in the order of submission.
    std::vector<JobRecord*> all();
    /// A live job with this output; null: none.
    const JobRecord* maker(std::string_view output) const;
    /// What runs, then what waits, then what has ended (with the last five lines of their logs), the newest
    /// first of each; at most `most` in all.
    std::vector<proto::JobStatus> list(std::size_t most) const;

  private:
    JobStore store_;
    std::map<std::int64_t, JobRecord> records_;  // by number
};

}  // namespace mote::server
