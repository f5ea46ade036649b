// SPDX-License-Identifier: GPL-3.0-or-later
//
// What jobs and clients leave behind, and who takes it away.
#include <asio/post.hpp>
#include <filesystem>
#include <utility>
#include <vector>

#include "server/jobs/drafts.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/job_request_check.h"

namespace mote::server {

/// Those of jobs that the earlier server did not come to remove.
void JobQueue::removeStrayDrafts() {
    std::vector<std::pair<proto::JobRequest, DraftOwner>> jobs;
    for (const auto* record : table_->all()) {
        if (keepsFiles(*record)) continue;
        proto::JobRequest request;
        request.set_output(record->status.request().output());
        jobs.push_back({request, {{}, record->status.id(), isLive(*record)}});
    }
    onDisk([roots = roots_, jobs = std::move(jobs)]() mutable {
        std::vector<DraftOwner> owners;
        for (auto& [request, owner] : jobs) {
            const auto output = findOutput(request, roots);
            if (!output.ok()) continue;
            owner.output = output->path;
            owners.push_back(std::move(owner));
        }
        sweepDrafts(owners);
    });
}

/// Those of clients and of jobs that are no more.
void JobQueue::removeStrayUploads() {
    std::error_code code;
    std::filesystem::directory_iterator entry(uploads_, code);
    for (; !code && entry != std::filesystem::directory_iterator(); entry.increment(code)) {
        const auto* record = table_->find(entry->path().filename().string());
        if (!record || !isLive(*record)) removeSoon(entry->path());
    }
}

void JobQueue::onDisk(std::function<void()> work) {
    asio::post(disk_, std::move(work));
}

/// Nothing of the job runs any more.
void JobQueue::discardDraft(const std::filesystem::path& output, const std::string& job) {
    const auto aside = setDraftAside(output, job);
    if (!aside.empty()) onDisk([aside] { removeDraft(aside); });
}

}  // namespace mote::server
