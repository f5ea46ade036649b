// SPDX-License-Identifier: GPL-3.0-or-later
//
// A session's commands about jobs, and what films have left.
#include "server/session/session.h"

namespace mote::server {
namespace {

proto::ServerMessage failure(const Error& error) {
    return failureMessage(0, error, false);
}

}  // namespace

proto::ServerMessage Session::submitJob(const proto::SubmitJob& message) {
    const auto resolved = uploads_.resolve(message.job());
    if (!resolved.ok()) return failure(resolved.error().within("job"));
    return told(
        context_.jobs->submit(*resolved, {message.again(), message.time_limit_s(), std::to_string(id_)}),
        "job");
}

proto::ServerMessage Session::retryJob(const std::string& id) {
    return told(context_.jobs->retry(id, std::to_string(id_)), "");
}

proto::ServerMessage Session::told(Result<proto::JobStatus> job, std::string_view field) {
    if (!job.ok()) return failure(field.empty() ? job.error() : job.error().within(field));
    proto::ServerMessage message;
    *message.mutable_job() = *std::move(job);
    return message;
}

proto::ServerMessage Session::upload(const proto::Upload& part) {
    const auto size = uploads_.add(part);
    if (!size.ok()) return failure(size.error());
    proto::ServerMessage message;
    message.mutable_uploaded()->set_name(part.name());
    message.mutable_uploaded()->set_size(*size);
    return message;
}

proto::ServerMessage Session::cancelJob(const std::string& id) {
    const auto status = context_.jobs->cancel(id);
    if (!status.ok()) return failure(status.error());
    return told(context_.jobs->find(id), "");
}

proto::ServerMessage Session::listJobs(const proto::ListJobs& wanted) {
    proto::ServerMessage message;
    *message.mutable_jobs() = context_.jobs->page(wanted.first(), wanted.count());
    return message;
}

proto::ServerMessage Session::watchJobs() {
    proto::ServerMessage message;
    auto& jobs = *message.mutable_jobs();
    for (auto& job : context_.jobs->list()) *jobs.add_jobs() = std::move(job);
    jobs.set_total(context_.jobs->size());
    return message;
}

/// The disk is read on a thread of the queue's.
asio::awaitable<Reply> Session::fetchFilm(const proto::FetchFilm& request) {
    const auto answer = std::make_shared<std::optional<Result<FilmPiece>>>();
    context_.jobs->fetchFilm(request, [weak = weak_from_this(), answer](Result<FilmPiece> piece) {
        answer->emplace(std::move(piece));
        if (const auto self = weak.lock()) self->workerWake_.notify();
    });
    while (!*answer && !closed_) co_await workerWake_.wait();
    if (!*answer) co_return failure({ErrorCode::cancelled, "connection", "closed"});
    if (!(*answer)->ok()) co_return failure((*answer)->error());
    auto piece = std::move((*answer)->value());
    proto::ServerMessage message;
    *message.mutable_film_piece() = std::move(piece.message);
    co_return Reply(std::move(message), std::move(piece.bytes));
}

}  // namespace mote::server
