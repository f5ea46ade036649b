// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "protocol/base/json.h"
#include "protocol/base/utf8.h"
#include "server/log.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

/// One prepared statement, bound from left to right. A failed preparation shows in step(), and in the
/// database's error. Lives no longer than the database.
class SqlStatement {
  public:
    SqlStatement(sqlite3* database, const std::string& sql) {
        prepared_ = sqlite3_prepare_v2(database, sql.c_str(), -1, &statement_, nullptr);
    }
    ~SqlStatement() { sqlite3_finalize(statement_); }
    SqlStatement(const SqlStatement&) = delete;
    SqlStatement& operator=(const SqlStatement&) = delete;

    SqlStatement& bind(std::int64_t value) {
        sqlite3_bind_int64(statement_, ++bound_, value);
        return *this;
    }
    SqlStatement& bind(double value) {
        sqlite3_bind_double(statement_, ++bound_, value);
        return *this;
    }
    SqlStatement& bind(const std::string& text) {
        sqlite3_bind_text(statement_, ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
        return *this;
    }

    /// SQLITE_ROW, SQLITE_DONE or an error's code.
    int step() { return prepared_ == SQLITE_OK ? sqlite3_step(statement_) : prepared_; }

    std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
    double real(int column) const { return sqlite3_column_double(statement_, column); }
    std::string text(int column) const {
        const auto* data = sqlite3_column_text(statement_, column);
        const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
        return data ? std::string(reinterpret_cast<const char*>(data), size) : std::string();
    }

  private:
    sqlite3_stmt* statement_ = nullptr;
    int prepared_ = SQLITE_OK;
    int bound_ = 0;
};

constexpr int kApplicationId = 0x6d6f7465;  // "mote"
constexpr int kVersion = 2;                 // of the schema

// A server, or a machine, that ends between two transactions must find every job as it was: WAL with one
// process, which EXCLUSIVE lets work on network file systems too.
constexpr const char* kPragmas =
    "PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA "
    "trusted_schema=OFF;";

constexpr const char* kSchema =
    "BEGIN IMMEDIATE;"
    "CREATE TABLE jobs("
    " number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT UNIQUE NOT NULL, state INTEGER NOT NULL,"
    " request TEXT NOT NULL, progress REAL NOT NULL, phase TEXT NOT NULL, error TEXT NOT NULL, log TEXT NOT "
    "NULL,"
    " created_ms INTEGER NOT NULL, started_ms INTEGER NOT NULL, finished_ms INTEGER NOT NULL,"
    " attempts INTEGER NOT NULL, cancel INTEGER NOT NULL, handle TEXT NOT NULL,"
    " runner TEXT NOT NULL, runner_id TEXT NOT NULL, interrupted INTEGER NOT NULL,"
    " time_limit INTEGER NOT NULL, digest TEXT NOT NULL, made TEXT NOT NULL) STRICT;"
    "PRAGMA application_id=1836020837;"
    "PRAGMA user_version=2;"
    "COMMIT;";
static_assert(kApplicationId == 1836020837 && kVersion == 2, "as in kSchema");

// What version 1 did not know, as it is where nothing is known.
constexpr const char* kFromVersion1 =
    "BEGIN IMMEDIATE;"
    "ALTER TABLE jobs ADD COLUMN runner TEXT NOT NULL DEFAULT '';"
    "ALTER TABLE jobs ADD COLUMN runner_id TEXT NOT NULL DEFAULT '';"
    "ALTER TABLE jobs ADD COLUMN interrupted INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN time_limit INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN digest TEXT NOT NULL DEFAULT '';"
    "ALTER TABLE jobs ADD COLUMN made TEXT NOT NULL DEFAULT '';"
    "PRAGMA user_version=2;"
    "COMMIT;";

// In the order of bindStatus.
const std::string kColumns =
    "id, state, request, progress, phase, error, log, created_ms, started_ms, finished_ms, attempts,"
    " cancel, handle, runner, runner_id, interrupted, time_limit, digest, made";

Error failure(sqlite3* database) {
    const int code = sqlite3_errcode(database) & 0xff;
    const auto kind = code == SQLITE_FULL                               ? ErrorCode::resourceExhausted
                      : code == SQLITE_CORRUPT || code == SQLITE_NOTADB ? ErrorCode::corrupt
                      : code == SQLITE_PERM || code == SQLITE_READONLY || code == SQLITE_CANTOPEN
                          ? ErrorCode::permissionDenied
                          : ErrorCode::internal;
    return {kind, "jobs.sqlite", sqlite3_errmsg(database)};
}

Status execute(sqlite3* database, const char* sql) {
    if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK) return success();
    auto error = failure(database);
    sqlite3_exec(database, "ROLLBACK", nullptr, nullptr, nullptr);
    return error;
}

/// The first column of the first row.
Result<std::string> ask(sqlite3* database, const char* sql) {
    SqlStatement statement(database, sql);
    if (statement.step() != SQLITE_ROW) return failure(database);
    return statement.text(0);
}

/// A damaged number of a later version is no full disk: then the file is not what it says.
Status takeUpVersion1(sqlite3* database) {
    const auto later = ask(database, "SELECT count(*) FROM pragma_table_info('jobs') WHERE name='made'");
    if (later.ok() && later.value() != "0")
        return Error{ErrorCode::corrupt, "jobs.sqlite", "is not of the version that it says"};
    return execute(database, kFromVersion1);
}

/// Whether the file is a job database of ours; makes the table in an empty one.
Status prepareSchema(sqlite3* database) {
    MOTE_ASSIGN_OR_RETURN(const auto check, ask(database, "PRAGMA quick_check(1)"));
    if (check != "ok") return Error{ErrorCode::corrupt, "jobs.sqlite", check};
    const auto tables = ask(database, "SELECT count(*) FROM sqlite_schema");
    const auto id = ask(database, "PRAGMA application_id");
    const auto version = ask(database, "PRAGMA user_version");
    if (!tables.ok() || !id.ok() || !version.ok()) return failure(database);
    if (tables.value() == "0") return execute(database, kSchema);
    if (id.value() != std::to_string(kApplicationId)) {
        return Error{ErrorCode::corrupt, "jobs.sqlite", "is no database of jobs"};
    }
    if (version.value() == "1") return takeUpVersion1(database);
    if (version.value() != std::to_string(kVersion)) {
        return Error{ErrorCode::unsupported, "jobs.sqlite",
                     fmt::format("has version {}, this program knows version {}", version.value(), kVersion)};
    }
    return ask(database, "SELECT count(number) FROM jobs").ok() ? success() : Status(failure(database));
}

void bindStatus(SqlStatement& statement, const JobRecord& record) {
    const auto& status = record.status;
    std::string log;
    for (const auto& line : status.log()) log += line + "\n";
    statement.bind(status.id()).bind(std::int64_t{status.state()}).bind(toJsonLine(status.request()));
    statement.bind(status.progress()).bind(status.phase()).bind(status.error()).bind(log);
    statement.bind(status.created_ms()).bind(status.started_ms()).bind(status.finished_ms());
    statement.bind(std::int64_t{record.attempts})
        .bind(std::int64_t{record.cancelRequested})
        .bind(record.handle);
    statement.bind(status.runner()).bind(status.runner_id()).bind(std::int64_t{status.interrupted()});
    statement.bind(std::int64_t{status.time_limit_s()}).bind(record.digest).bind(record.made);
}

Result<JobRecord> readRecord(const SqlStatement& row) {
    JobRecord record;
    record.number = row.integer(0);
    auto& status = record.status;
    status.set_id(row.text(1));
    if (!isJobId(status.id())) {
        return Error{ErrorCode::corrupt, "jobs.sqlite",
                     fmt::format("row {} has no id of a job, but \"{}\"", record.number, status.id())};
    }
    const auto state = row.integer(2);
    if (state < proto::JobStatus::QUEUED || state > proto::JobStatus::CANCELLED) {
        return Error{ErrorCode::corrupt, "jobs.sqlite",
                     fmt::format("job {} has no known state", status.id())};
    }
    status.set_state(static_cast<proto::JobStatus::State>(state));
    MOTE_RETURN_IF_ERROR(parseJson(row.text(3), *status.mutable_request(), "jobs.sqlite"));
    status.set_progress(row.real(4));
    status.set_phase(row.text(5));
    status.set_error(row.text(6));
    const auto log = row.text(7);
    for (std::string_view rest = log; !rest.empty();) {
        const auto end = rest.find('\n');
        status.add_log(std::string(rest.substr(0, end)));
        rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    }
    status.set_created_ms(row.integer(8));
    status.set_started_ms(row.integer(9));
    status.set_finished_ms(row.integer(10));
    record.attempts = static_cast<int>(row.integer(11));
    record.cancelRequested = row.integer(12) != 0;
    record.handle = row.text(13);
    status.set_runner(row.text(14));
    status.set_runner_id(row.text(15));
    status.set_interrupted(static_cast<std::uint32_t>(row.integer(16)));
    status.set_time_limit_s(static_cast<std::uint32_t>(row.integer(17)));
    record.digest = row.text(18);
    record.made = row.text(19);
    return record;
}

/// Renames the file and its log files, which belong to it, to the first free FILE.broken-N.
Result<fs::path> moveAside(const fs::path& file) {
    std::error_code code;
    for (int n = 1; n < 1000; ++n) {
        const fs::path aside = fmt::format("{}.broken-{}", file.string(), n);
        if (fs::exists(aside, code)) continue;
        fs::rename(file, aside, code);
        if (code) break;
        for (const char* suffix : {"-wal", "-shm"})
            fs::rename(file.string() + suffix, aside.string() + suffix, code);
        return aside;
    }
    return Error{ErrorCode::permissionDenied, file.string(), "is broken and cannot be moved aside"};
}

/// A database, and where what stood in its place went, if that was broken.
struct Opened {
    JobDatabase database;
    fs::path aside;
};

Result<Opened> openOrMake(const fs::path& file) {
    auto database = JobDatabase::open(file);
    if (database.ok()) return Opened{*std::move(database), {}};
    if (database.error().code != ErrorCode::corrupt) return database.error();
    MOTE_ASSIGN_OR_RETURN(auto aside, moveAside(file));
    log::error("the database of jobs is broken ({}): it was moved to {}", toLogText(database.error().message),
               aside.string());
    MOTE_ASSIGN_OR_RETURN(auto fresh, JobDatabase::open(file));
    return Opened{std::move(fresh), std::move(aside)};
}

const JobRecord* find(const std::vector<JobRecord>& jobs, std::int64_t number) {
    const auto found =
        std::lower_bound(jobs.begin(), jobs.end(), number,
                         [](const JobRecord& job, auto wanted) { return job.number < wanted; });
    return found != jobs.end() && found->number == number ? &*found : nullptr;
}

}  // namespace

void JobDatabase::Close::operator()(sqlite3* database) const {
    sqlite3_close_v2(database);
}

Result<JobDatabase> JobDatabase::open(const std::filesystem::path& file) {
    sqlite3* raw = nullptr;
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_NOFOLLOW;
    const int opened = sqlite3_open_v2(file.c_str(), &raw, flags, nullptr);
    Handle database(raw);
    if (opened != SQLITE_OK) return failure(raw);
    MOTE_RETURN_IF_ERROR(execute(raw, kPragmas));
    MOTE_RETURN_IF_ERROR(prepareSchema(raw));
    return JobDatabase(std::move(database));
}

JobDatabase::Content JobDatabase::load() const {
    SqlStatement rows(database_.get(), "SELECT number, " + kColumns + " FROM jobs ORDER BY number");
    Content content;
    int code = SQLITE_ROW;
    while ((code = rows.step()) == SQLITE_ROW) {
        auto record = readRecord(rows);
        if (record.ok()) {
            content.jobs.push_back(*std::move(record));
        } else {
            log::warn("a job cannot be read: {}", toLogText(record.error().toString()));
            content.unreadable.push_back(rows.integer(0));
        }
    }
    if (code != SQLITE_DONE) content.broken = failure(database_.get());
    return content;
}

Status JobDatabase::insert(JobRecord& record) {
    SqlStatement statement(
        database_.get(),
        "INSERT INTO jobs(" + kColumns + ") VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    bindStatus(statement, record);
    if (statement.step() != SQLITE_DONE) return failure(database_.get());
    record.number = sqlite3_last_insert_rowid(database_.get());
    return success();
}

Status JobDatabase::write(const JobRecord& record) {
    SqlStatement statement(
        database_.get(), "INSERT OR REPLACE INTO jobs(" + kColumns +
                             ", number) VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    bindStatus(statement, record);
    statement.bind(record.number);
    return statement.step() == SQLITE_DONE ? success() : Status(failure(database_.get()));
}

Status JobDatabase::remove(std::int64_t number) {
    SqlStatement statement(database_.get(), "DELETE FROM jobs WHERE number=?");
    statement.bind(number);
    return statement.step() == SQLITE_DONE ? success() : Status(failure(database_.get()));
}

Status JobDatabase::indexAnew() {
    return execute(database_.get(), "REINDEX");
}

Status JobDatabase::copy(const JobDatabase& from) {
    auto* backup = sqlite3_backup_init(database_.get(), "main", from.database_.get(), "main");
    if (backup == nullptr) return failure(database_.get());
    sqlite3_backup_step(backup, -1);
    return sqlite3_backup_finish(backup) == SQLITE_OK ? success() : Status(failure(database_.get()));
}

// ------------------------------------------------------------------------------------------ store

fs::path JobStore::copyOf(const fs::path& file) {
    return file.parent_path() / (file.stem().string() + ".copy" + file.extension().string());
}

Result<JobStore> JobStore::open(const fs::path& file) {
    MOTE_ASSIGN_OR_RETURN(auto first, openOrMake(file));
    MOTE_ASSIGN_OR_RETURN(auto second, openOrMake(copyOf(file)));
    JobStore store(std::move(first.database), std::move(second.database));
    store.setAside_ = std::move(first.aside);
    return store;
}

/// The one file is believed as long as it makes sense: the copy may lack the latest change. Else what is
/// readable in either counts.
Result<std::vector<JobRecord>> JobStore::load() {
    auto content = database_.load();
    const auto spare = copy_.load();
    if (content.broken && spare.broken) return *content.broken;
    // Both have every job: none where the copy has some was emptied or made anew.
    const bool emptied = content.jobs.empty() && content.unreadable.empty() && !spare.jobs.empty();
    const bool broken = content.broken || (!content.unreadable.empty() && !database_.indexAnew().ok());
    const auto wanted = [&](const JobRecord& job) {
        return emptied || broken || std::ranges::count(content.unreadable, job.number) > 0;
    };
    std::vector<JobRecord> lacking;
    for (const auto& job : spare.jobs) {
        if (wanted(job) && !find(content.jobs, job.number)) lacking.push_back(job);
    }
    // The file becomes what the copy is, and gets back what it knew; or it gets what it lacks.
    const bool anew = (emptied || broken) && !spare.broken;
    if (anew) MOTE_RETURN_IF_ERROR(database_.copy(copy_));
    for (const auto& job : anew ? content.jobs : lacking) MOTE_RETURN_IF_ERROR(database_.write(job));
    if (!lacking.empty()) log::warn("{} jobs are taken from the copy of their database", lacking.size());
    content.jobs.insert(content.jobs.end(), lacking.begin(), lacking.end());
    std::ranges::sort(content.jobs, {}, &JobRecord::number);
    for (const auto number : content.unreadable) {
        if (!find(content.jobs, number)) log::warn("job number {} is left out: its row is damaged", number);
    }
    follow(success());
    return std::move(content.jobs);
}

/// The copy has the change, or is made anew: from then on it has all.
void JobStore::follow(Status copied) {
    if (copied.ok() && copyIsBehind_) copied = copy_.copy(database_);
    copyIsBehind_ = !copied.ok();
    if (copyIsBehind_) log::warn("the copy of the database of jobs is behind: {}", copied.error().toString());
}

Status JobStore::insert(JobRecord& record) {
    MOTE_RETURN_IF_ERROR(database_.insert(record));
    follow(copy_.write(record));
    return success();
}

Status JobStore::update(const JobRecord& record) {
    MOTE_RETURN_IF_ERROR(database_.write(record));
    follow(copy_.write(record));
    return success();
}

Status JobStore::remove(std::int64_t number) {
    MOTE_RETURN_IF_ERROR(database_.remove(number));
    follow(copy_.remove(number));
    return success();
}

}  // namespace mote::server
