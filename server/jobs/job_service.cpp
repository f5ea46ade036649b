// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_service.h"

#include <asio/post.hpp>
#include <utility>

#include "server/jobs/look/list_folder.h"

namespace mote::server {

JobService::JobService(asio::io_context& home, JobSettings settings)
    : home_(home),
      ownRoots_(settings.roots),
      work_(context_->get_executor()),
      queue_(*context_, std::move(settings)) {}

JobService::~JobService() {
    folders_.stop();
    folders_.join();
    if (!thread_.joinable()) return;
    context_->stop();
    thread_.join();
}

Status JobService::start(JobQueue::Listener changed) {
    changed_ = std::move(changed);
    queue_.onChange([this](const proto::JobStatus& job) { tell(job); });
    MOTE_RETURN_IF_ERROR(queue_.start());
    MOTE_RETURN_IF_ERROR(startLooks());
    *counts_ = queue_.counts();
    thread_ = std::thread([this] { context_->run(); });
    return success();
}

/// Of the user's own roots: what clients upload is no folder that is listed.
Status JobService::startLooks() {
    MOTE_ASSIGN_OR_RETURN(roots_, storage::Roots::parse(ownRoots_));
    looks_.emplace(*context_, queue_.settings(), roots_);
    return looks_->start();
}

void JobService::stop() {
    asio::post(*context_, [this] { queue_.stop(); });
}

void JobService::ask(Question question, Answered answered) {
    asio::post(*context_, [this, question = std::move(question), answered = std::move(answered)] {
        answered(question(queue_));
    });
}

/// What a job is now, and not what it was at this change: an answer that was given meanwhile is no newer.
void JobService::tell(const proto::JobStatus& job) {
    auto now = queue_.find(job.id());
    asio::post(home_, [changed = changed_, now = now.ok() ? *std::move(now) : job] { changed(now); });
    tellCounts();
    // Old jobs are forgotten right after one has ended.
    asio::post(*context_, [this] { tellCounts(); });
}

void JobService::tellCounts() {
    asio::post(home_, [kept = counts_, counts = queue_.counts()]() mutable { *kept = std::move(counts); });
}

void JobService::fetchArtifact(const proto::FetchFilm& request, JobQueue::ArtifactListener done) {
    asio::post(*context_, [this, request, done = std::move(done)] { queue_.fetchArtifact(request, done); });
}

void JobService::listFolder(const proto::ListFolder& wanted,
                            std::function<void(Result<proto::Folder>)> done) {
    asio::post(folders_,
               [this, wanted, done = std::move(done)] { done(server::listFolder(wanted, roots_)); });
}

LookRuns::Ticket JobService::look(const proto::LookAtFile& wanted, LookRuns::Answered done) {
    const auto ticket = ++tickets_;
    asio::post(*context_, [this, ticket, wanted, done = std::move(done)]() mutable {
        looks_->look(ticket, wanted, std::move(done));
    });
    return ticket;
}

void JobService::cancelLook(LookRuns::Ticket ticket) {
    asio::post(*context_, [this, ticket] { looks_->cancel(ticket); });
}

Uploads::Remove JobService::remover() {
    return
        [context = std::weak_ptr(context_), remove = queue_.remover()](const std::filesystem::path& folder) {
            const auto alive = context.lock();
            if (alive) asio::post(*alive, [remove, folder] { remove(folder); });
        };
}

}  // namespace mote::server
