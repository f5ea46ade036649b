// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "protocol/scene/utf8.h"
#include "server/log.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

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
