// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_table.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/log.h"

namespace mote::server {
namespace {

/// The part of the list that it stands in: 0 runs, 1 waits, 2 has ended.
int listedIn(const JobRecord& record) {
    if (!isLive(record)) return 2;
    return record.status.state() == proto::JobStatus::RUNNING ? 0 : 1;
}

constexpr int kListedLines = 5;  // of a finished job's log: a list of hundreds goes over the wire at once

proto::JobStatus listed(const JobRecord& record) {
    auto status = record.status;
    auto& log = *status.mutable_log();
    if (!isLive(record) && log.size() > kListedLines) log.DeleteSubrange(0, log.size() - kListedLines);
    return status;
}

}  // namespace

Status JobTable::load() {
    MOTE_ASSIGN_OR_RETURN(auto records, store_.load());
    std::map<std::int64_t, JobRecord> known;
    for (auto& record : records) known.emplace(record.number, std::move(record));
    records_ = std::move(known);
    unsaved_.clear();
    return success();
}

Result<JobRecord*> JobTable::add(JobRecord record) {
    MOTE_RETURN_IF_ERROR(store_.insert(record));
    const auto number = record.number;
    return &records_.insert_or_assign(number, std::move(record)).first->second;
}

Status JobTable::save(const JobRecord& record) {
    auto saved = store_.update(record);
    if (saved.ok()) {
        unsaved_.erase(record.number);
    } else if (unsaved_.insert(record.number).second) {
        log::error(log::job(record.status.id()), "cannot be kept: {}", saved.error().toString());
    }
    return saved;
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
            break;
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

std::vector<JobRecord*> JobTable::queued(bool film) {
    struct Client {
        std::size_t before = 0;   // jobs that run, or wait before the next one
        std::int64_t lastMs = 0;  // when one began last
    };
    struct Turn {
        std::size_t before;
        std::int64_t lastMs;
        JobRecord* record;
    };
    std::map<std::string_view, Client> clients;
    for (const auto& [number, record] : records_) {
        if (isFilm(record) != film) continue;
        auto& client = clients[record.client];
        client.lastMs = std::max(client.lastMs, record.status.started_ms());
        if (record.status.state() == proto::JobStatus::RUNNING) ++client.before;
    }
    std::vector<Turn> turns;
    for (auto& [number, record] : records_) {
        if (record.status.state() != proto::JobStatus::QUEUED || isFilm(record) != film) continue;
        auto& client = clients[record.client];
        turns.push_back({client.before++, client.lastMs, &record});
    }
    std::ranges::stable_sort(turns, {}, [](const Turn& turn) { return std::pair(turn.before, turn.lastMs); });
    std::vector<JobRecord*> records;
    records.reserve(turns.size());
    for (const auto& turn : turns) records.push_back(turn.record);
    return records;
}

std::size_t JobTable::waiting(const std::string& client) const {
    return static_cast<std::size_t>(std::count_if(records_.begin(), records_.end(), [&](const auto& entry) {
        return entry.second.status.state() == proto::JobStatus::QUEUED && entry.second.client == client;
    }));
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
        if (isLive(record) && !keepsFiles(record) && record.status.request().output() == output)
            return &record;
    }
    return nullptr;
}

std::vector<proto::JobStatus> JobTable::list(std::size_t most) const {
    std::vector<proto::JobStatus> statuses;
    // What runs is never hidden behind what waits.
    for (const int part : {0, 1, 2}) {
        for (auto entry = records_.rbegin(); entry != records_.rend(); ++entry) {
            if (statuses.size() >= most) return statuses;
            if (listedIn(entry->second) == part) statuses.push_back(listed(entry->second));
        }
    }
    return statuses;
}

std::vector<proto::JobStatus> JobTable::page(std::uint64_t first, std::size_t count) const {
    std::vector<proto::JobStatus> statuses;
    if (first >= records_.size()) return statuses;
    auto entry = std::next(records_.rbegin(), static_cast<std::ptrdiff_t>(first));
    for (; entry != records_.rend() && statuses.size() < count; ++entry)
        statuses.push_back(listed(entry->second));
    return statuses;
}

const JobRecord* JobTable::latest(const std::string& digest,
                                  const std::function<bool(const JobRecord&)>& wanted) const {
    for (auto entry = records_.rbegin(); entry != records_.rend(); ++entry) {
        if (entry->second.digest == digest && wanted(entry->second)) return &entry->second;
    }
    return nullptr;
}

}  // namespace mote::server
