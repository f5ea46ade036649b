// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobStore: the jobs of a server on the disk, twice: where one file is damaged, the other one knows them.
// Owned by the queue and used on its thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/job_request.h"

struct sqlite3;

namespace mote::server {

/// JobRecord: what is remembered of a job: what clients see, and what a restarted server needs. A value.
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

/// ms since 1970, as a record's times are.
inline std::int64_t unixMs() {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
}

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
    return keepsFiles(record) && record.status.state() == proto::JobStatus::SUCCEEDED &&
           !record.cancelRequested;
}

inline bool isLive(const JobRecord& record) {
    return record.status.state() == proto::JobStatus::QUEUED ||
           record.status.state() == proto::JobStatus::RUNNING;
}

/// JobDatabase: jobs in one SQLite file, on the disk before a call returns. One owner, one thread; every call
/// is one transaction.
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
