// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_table.h"

#include <algorithm>
#include <utility>

#include "server/log.h"

namespace mote::server {
namespace {

constexpr int kListedLines = 5;  // of a finished job's log: a list of hundreds goes over the wire at once

}  // namespace

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

void JobTable::prune(std::size_t kept) {
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
        entry = records_.erase(entry);
        --finished;
    }
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

JobRecord* JobTable::nextQueued() {
    for (auto& [number, record] : records_) {
        if (record.status.state() == proto::JobStatus::QUEUED) return &record;
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
        if (isLive(record) && record.status.request().output() == output) return &record;
    }
    return nullptr;
}

std::vector<proto::JobStatus> JobTable::list(std::size_t most) const {
    std::vector<proto::JobStatus> statuses;
    for (const bool live : {true, false}) {
        for (auto entry = records_.rbegin(); entry != records_.rend(); ++entry) {
            if (statuses.size() >= most) return statuses;
            if (isLive(entry->second) != live) continue;
            auto& log = *statuses.emplace_back(entry->second.status).mutable_log();
            if (!live && log.size() > kListedLines) log.DeleteSubrange(0, log.size() - kListedLines);
        }
    }
    return statuses;
}

}  // namespace mote::server
