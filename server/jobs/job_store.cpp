// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "protocol/scene/json.h"
#include "protocol/scene/utf8.h"
#include "server/log.h"

namespace mote::server {
namespace {

/// One prepared statement, bound from left to right. A failed preparation shows in step(), and in the
/// database's error. Lives no longer than the database.
class SqlStatement {
  public:
    SqlStatement(sqlite3* database, const char* sql) {
        prepared_ = sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr);
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
constexpr int kVersion = 1;                 // of the schema

// A server that ends between two transactions must find every job as it was: WAL with one process, which
// EXCLUSIVE lets work on network file systems too.
constexpr const char* kPragmas =
    "PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA "
    "trusted_schema=OFF;";

constexpr const char* kSchema =
    "BEGIN IMMEDIATE;"
    "CREATE TABLE jobs("
    " number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT UNIQUE NOT NULL, state INTEGER NOT NULL,"
    " request TEXT NOT NULL, progress REAL NOT NULL, phase TEXT NOT NULL, error TEXT NOT NULL, log TEXT NOT "
    "NULL,"
    " created_ms INTEGER NOT NULL, started_ms INTEGER NOT NULL, finished_ms INTEGER NOT NULL,"
    " attempts INTEGER NOT NULL, cancel INTEGER NOT NULL, handle TEXT NOT NULL) STRICT;"
    "PRAGMA application_id=1836020837;"
    "PRAGMA user_version=1;"
    "COMMIT;";
static_assert(kApplicationId == 1836020837 && kVersion == 1, "as in kSchema");

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
    if (version.value() != std::to_string(kVersion)) {
        return Error{ErrorCode::unsupported, "jobs.sqlite",
                     fmt::format("has version {}, this program knows version {}", version.value(), kVersion)};
    }
    return ask(database, "SELECT count(number) FROM jobs").ok() ? success() : Status(failure(database));
}

/// Renames the file (its log files go: they belong to it) to the first free FILE.broken-N.
Result<std::filesystem::path> moveAside(const std::filesystem::path& file) {
    std::error_code code;
    for (int n = 1; n < 1000; ++n) {
        const std::filesystem::path aside = fmt::format("{}.broken-{}", file.string(), n);
        if (std::filesystem::exists(aside, code)) continue;
        std::filesystem::rename(file, aside, code);
        if (code) break;
        for (const char* suffix : {"-wal", "-shm"}) {
            std::filesystem::rename(file.string() + suffix, aside.string() + suffix, code);
        }
        return aside;
    }
    return Error{ErrorCode::permissionDenied, file.string(), "is broken and cannot be moved aside"};
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
    return record;
}

/// The part of the list that it stands in: 0 runs, 1 waits, 2 has ended.
int listedIn(const JobRecord& record) {
    if (!isLive(record)) return 2;
    return record.status.state() == proto::JobStatus::RUNNING ? 0 : 1;
}

constexpr int kListedLines = 5;  // of a finished job's log: a list of hundreds goes over the wire at once

}  // namespace

void JobStore::Close::operator()(sqlite3* database) const {
    sqlite3_close_v2(database);
}

Result<JobStore::Database> JobStore::connect(const std::filesystem::path& file) {
    sqlite3* raw = nullptr;
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_NOFOLLOW;
    const int opened = sqlite3_open_v2(file.c_str(), &raw, flags, nullptr);
    Database database(raw);
    if (opened != SQLITE_OK) return failure(raw);
    MOTE_RETURN_IF_ERROR(execute(raw, kPragmas));
    MOTE_RETURN_IF_ERROR(prepareSchema(raw));
    return database;
}

Result<JobStore> JobStore::open(const std::filesystem::path& file) {
    auto database = connect(file);
    std::filesystem::path aside;
    if (!database.ok() && database.error().code == ErrorCode::corrupt) {
        MOTE_ASSIGN_OR_RETURN(aside, moveAside(file));
        log::error("the database of jobs is broken ({}): it was moved to {} and a new one begun",
                   database.error().message, aside.string());
        database = connect(file);
    }
    if (!database.ok()) return database.error();
    JobStore store(*std::move(database));
    store.setAside_ = std::move(aside);
    return store;
}

Result<std::vector<JobRecord>> JobStore::load() const {
    SqlStatement rows(
        database_.get(),
        "SELECT number, id, state, request, progress, phase, error, log, created_ms, started_ms,"
        " finished_ms, attempts, cancel, handle FROM jobs ORDER BY number");
    std::vector<JobRecord> records;
    int code = SQLITE_ROW;
    while ((code = rows.step()) == SQLITE_ROW) {
        auto record = readRecord(rows);
        if (record.ok()) {
            records.push_back(*std::move(record));
        } else {
            log::warn("a job is left out: {}", toLogText(record.error().toString()));
        }
    }
    if (code != SQLITE_DONE) return failure(database_.get());
    return records;
}

Status JobStore::insert(JobRecord& record) {
    SqlStatement statement(database_.get(),
                           "INSERT INTO jobs(id, state, request, progress, phase, error, log, created_ms,"
                           " started_ms, finished_ms, attempts, cancel, handle)"
                           " VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    bindStatus(statement, record);
    if (statement.step() != SQLITE_DONE) return failure(database_.get());
    record.number = sqlite3_last_insert_rowid(database_.get());
    return success();
}

Status JobStore::update(const JobRecord& record) {
    SqlStatement statement(database_.get(),
                           "UPDATE jobs SET id=?, state=?, request=?, progress=?, phase=?, error=?, log=?,"
                           " created_ms=?, started_ms=?, finished_ms=?, attempts=?, cancel=?, handle=?"
                           " WHERE number=?");
    bindStatus(statement, record);
    statement.bind(record.number);
    return statement.step() == SQLITE_DONE ? success() : Status(failure(database_.get()));
}

Status JobStore::remove(std::int64_t number) {
    SqlStatement statement(database_.get(), "DELETE FROM jobs WHERE number=?");
    statement.bind(number);
    return statement.step() == SQLITE_DONE ? success() : Status(failure(database_.get()));
}

Status JobTable::load() {
    MOTE_ASSIGN_OR_RETURN(auto records, store_.load());
    for (auto& record : records) records_.emplace(record.number, std::move(record));
    return success();
}

Result<JobRecord*> JobTable::add(JobRecord record) {
    MOTE_RETURN_IF_ERROR(store_.insert(record));
    const auto number = record.number;
    return &records_.insert_or_assign(number, std::move(record)).first->second;
}

void JobTable::save(const JobRecord& record) {
    if (const auto saved = store_.update(record); !saved.ok()) {
        log::error("job {} cannot be kept: {}", record.status.id(), saved.error().toString());
    }
}

std::vector<JobRecord> JobTable::prune(std::size_t kept) {
    std::vector<JobRecord> forgotten;
    auto finished = static_cast<std::size_t>(std::count_if(
        records_.begin(), records_.end(), [](const auto& entry) { return !isLive(entry.second); }));
    for (auto entry = records_.begin(); entry != records_.end() && finished > kept;) {
        if (isLive(entry->second)) {
            ++entry;
            continue;
        }
        if (const auto removed = store_.remove(entry->first); !removed.ok()) {
            log::error("an old job cannot be forgotten: {}", removed.error().toString());
        }
        forgotten.push_back(std::move(entry->second));
        entry = records_.erase(entry);
        --finished;
    }
    return forgotten;
}

JobRecord* JobTable::find(std::string_view id) {
    return const_cast<JobRecord*>(std::as_const(*this).find(id));
}

const JobRecord* JobTable::find(std::string_view id) const {
    for (const auto& [number, record] : records_) {
        if (record.status.id() == id) return &record;
    }
    return nullptr;
}

JobRecord* JobTable::find(std::int64_t number) {
    const auto entry = records_.find(number);
    return entry == records_.end() ? nullptr : &entry->second;
}

JobRecord* JobTable::nextQueued(bool film) {
    for (auto& [number, record] : records_) {
        if (record.status.state() == proto::JobStatus::QUEUED && isFilm(record) == film) return &record;
    }
    return nullptr;
}

std::size_t JobTable::count(proto::JobStatus::State state) const {
    return static_cast<std::size_t>(std::count_if(records_.begin(), records_.end(), [&](const auto& entry) {
        return entry.second.status.state() == state;
    }));
}

std::vector<JobRecord*> JobTable::all() {
    std::vector<JobRecord*> records;
    for (auto& [number, record] : records_) records.push_back(&record);
    return records;
}

const JobRecord* JobTable::maker(std::string_view output) const {
    for (const auto& [number, record] : records_) {
        if (isLive(record) && !isFilm(record) && record.status.request().output() == output) return &record;
    }
    return nullptr;
}

std::vector<proto::JobStatus> JobTable::list(std::size_t most) const {
    std::vector<proto::JobStatus> statuses;
    // What runs is never hidden behind what waits.
    for (const int part : {0, 1, 2}) {
        for (auto entry = records_.rbegin(); entry != records_.rend(); ++entry) {
            if (statuses.size() >= most) return statuses;
            if (listedIn(entry->second) != part) continue;
            auto& log = *statuses.emplace_back(entry->second.status).mutable_log();
            if (!isLive(entry->second) && log.size() > kListedLines)
                log.DeleteSubrange(0, log.size() - kListedLines);
        }
    }
    return statuses;
}

}  // namespace mote::server
