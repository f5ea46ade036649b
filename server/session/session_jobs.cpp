// SPDX-License-Identifier: GPL-3.0-or-later
//
// A session's commands about jobs, and what films have left.
#include "server/session/session.h"

namespace mote::server {
namespace {

using Answer = Result<proto::ServerMessage>;

Answer told(Result<proto::JobStatus> job) {
    if (!job.ok()) return job.error();
    proto::ServerMessage message;
    *message.mutable_job() = *std::move(job);
    return message;
}

JobService::Question retryJob(const std::string& id, SessionId client) {
    return [id, client = std::to_string(client)](JobQueue& jobs) { return told(jobs.retry(id, client)); };
}

JobService::Question cancelJob(const std::string& id) {
    return [id](JobQueue& jobs) -> Answer {
        MOTE_RETURN_IF_ERROR(jobs.cancel(id));
        return told(jobs.find(id));
    };
}

JobService::Question pageOfJobs(const proto::ListJobs& wanted) {
    return [wanted](const JobQueue& jobs) -> Answer {
        proto::ServerMessage message;
        *message.mutable_jobs() = jobs.page(wanted.first(), wanted.count());
        return message;
    };
}

}  // namespace

Answer allJobs(JobQueue& queue) {
    proto::ServerMessage message;
    auto& jobs = *message.mutable_jobs();
    for (auto& job : queue.list()) *jobs.add_jobs() = std::move(job);
    jobs.set_total(queue.size());
    return message;
}

/// Null: the command is not about jobs.
JobService::Question Session::jobQuestion(proto::ClientMessage& command) {
    using Body = proto::ClientMessage;
    switch (command.body_case()) {
        case Body::kSubmitJob:
            return submitJob(*command.mutable_submit_job());
        case Body::kRetryJob:
            return retryJob(command.retry_job().id(), id_);
        case Body::kListJobs:
            return pageOfJobs(command.list_jobs());
        case Body::kUpload:
            return upload(*command.mutable_upload());
        case Body::kCancelJob:
            return cancelJob(command.cancel_job().id());
        case Body::kWatchJobs:
            watchesJobs_ = true;
            context_.parked->watchJobs(id_);
            return allJobs;
        default:
            return nullptr;
    }
}

JobService::Question Session::submitJob(proto::SubmitJob& message) const {
    const auto job = std::make_shared<proto::JobRequest>(std::move(*message.mutable_job()));
    const JobWish wish{message.again(), message.time_limit_s(), std::to_string(id_)};
    return [job, wish, uploads = uploads_](JobQueue& jobs) -> Answer {
        const auto resolved = uploads->resolve(*job);
        if (!resolved.ok()) return resolved.error().within("job");
        auto status = jobs.submit(*resolved, wish);
        if (!status.ok()) return status.error().within("job");
        return told(std::move(status));
    };
}

JobService::Question Session::upload(proto::Upload& message) const {
    const auto part = std::make_shared<proto::Upload>(std::move(message));
    return [part, uploads = uploads_](JobQueue&) -> Answer {
        MOTE_ASSIGN_OR_RETURN(const auto size, uploads->add(*part));
        proto::ServerMessage uploaded;
        uploaded.mutable_uploaded()->set_name(part->name());
        uploaded.mutable_uploaded()->set_size(size);
        return uploaded;
    };
}

asio::awaitable<void> Session::askJobs(std::uint64_t request, JobService::Question question, Wakeup& wake) {
    const auto done = std::make_shared<bool>(false);
    context_.jobs->ask(std::move(question), [weak = weak_from_this(), &wake, done, request](Answer answer) {
        *done = true;
        const auto self = weak.lock();
        if (!self) return;
        self->orClose([&] { self->replyOfJobs(request, std::move(answer)); });
        wake.notify();
    });
    while (!*done && !closed_) co_await wake.wait();
}

/// At once, as the next thing that is told of jobs is newer.
void Session::replyOfJobs(std::uint64_t request, Answer answer) {
    if (closed_ || leaving_) return;
    if (!answer.ok()) return reply(request, failureMessage(0, answer.error(), false));
    outbox_.jobsTold(*answer);
    reply(request, *std::move(answer));
}

/// The disk is read on a thread of the queue's.
asio::awaitable<Reply> Session::fetchFilm(const proto::FetchFilm& request) {
    const auto answer = std::make_shared<std::optional<Result<FilmPiece>>>();
    context_.jobs->fetchFilm(request, [weak = weak_from_this(), answer](Result<FilmPiece> piece) {
        answer->emplace(std::move(piece));
        if (const auto self = weak.lock()) self->workerWake_.notify();
    });
    while (!*answer && !closed_) co_await workerWake_.wait();
    if (!*answer) co_return failureMessage(0, {ErrorCode::cancelled, "connection", "closed"}, false);
    if (!(*answer)->ok()) co_return failureMessage(0, (*answer)->error(), false);
    auto piece = std::move((*answer)->value());
    proto::ServerMessage message;
    *message.mutable_film_piece() = std::move(piece.message);
    co_return Reply(std::move(message), std::move(piece.bytes));
}

}  // namespace mote::server
