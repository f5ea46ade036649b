// SPDX-License-Identifier: GPL-3.0-or-later
//
// The commands of a session: questions with one answer each, answered in their order.
#include <asio/post.hpp>

#include "server/session/session.h"

namespace mote::server {
namespace {

proto::ServerMessage failure(const Error& error) {
    return failureMessage(0, error, false);
}

}  // namespace

asio::awaitable<void> Session::work() {
    while (!leaving_ && !closed_) {
        if (commands_.empty()) {
            co_await workerWake_.wait();
            continue;
        }
        const proto::ClientMessage command = std::move(commands_.front());
        commands_.pop_front();
        readerWake_.notify();
        auto message = co_await answer(command);
        // The writer wakes readers and workers alike when there is room again.
        while (!outbox_.room() && !closed_) co_await readerWake_.wait();
        reply(command.request(), std::move(message));
    }
}

asio::awaitable<proto::ServerMessage> Session::answer(const proto::ClientMessage& command) {
    using Body = proto::ClientMessage;
    switch (command.body_case()) {
        case Body::kListDatasets:
            co_return co_await listDatasets();
        case Body::kDescribe:
            co_return co_await describe(command.describe().dataset());
        case Body::kSubmitJob:
            co_return submitJob(command.submit_job().job());
        case Body::kCancelJob:
            co_return cancelJob(command.cancel_job().id());
        case Body::kWatchJobs:
            watchesJobs_ = true;
            co_return watchJobs();
        default:
            co_return failure({ErrorCode::unsupported, "message", "it is not known here"});
    }
}

/// What is on the disk now, not what was at the last look.
asio::awaitable<proto::ServerMessage> Session::listDatasets() {
    const auto done = std::make_shared<bool>(false);
    context_.datasets->rescan([weak = weak_from_this(), executor = executor_, done] {
        asio::post(executor, [weak, done] {
            *done = true;
            if (const auto self = weak.lock()) self->workerWake_.notify();
        });
    });
    while (!*done && !closed_) co_await workerWake_.wait();
    proto::ServerMessage message;
    *message.mutable_catalogue() = *context_.datasets->catalogue();
    co_return message;
}

asio::awaitable<proto::ServerMessage> Session::describe(const std::string& dataset) {
    const auto answer = std::make_shared<std::optional<Result<proto::Description>>>();
    const auto done = [weak = weak_from_this(), executor = executor_,
                       answer](Result<proto::Description> description) {
        asio::post(executor, [weak, answer, description = std::move(description)]() mutable {
            answer->emplace(std::move(description));
            if (const auto self = weak.lock()) self->workerWake_.notify();
        });
    };
    context_.datasets->describe(dataset, done);
    while (!*answer && !closed_) co_await workerWake_.wait();
    if (!*answer) co_return failure({ErrorCode::cancelled, "connection", "closed"});
    if (!(*answer)->ok()) co_return failure((*answer)->error());
    proto::ServerMessage message;
    *message.mutable_description() = std::move((*answer)->value());
    co_return message;
}

proto::ServerMessage Session::submitJob(const proto::JobRequest& request) {
    auto job = context_.jobs->submit(request);
    if (!job.ok()) return failure(job.error().within("job"));
    proto::ServerMessage message;
    *message.mutable_job() = *std::move(job);
    return message;
}

proto::ServerMessage Session::cancelJob(const std::string& id) {
    const auto status = context_.jobs->cancel(id);
    if (!status.ok()) return failure(status.error());
    auto job = context_.jobs->find(id);
    if (!job.ok()) return failure(job.error());
    proto::ServerMessage message;
    *message.mutable_job() = *std::move(job);
    return message;
}

proto::ServerMessage Session::watchJobs() {
    proto::ServerMessage message;
    auto& jobs = *message.mutable_jobs();
    for (auto& job : context_.jobs->list()) *jobs.add_jobs() = std::move(job);
    return message;
}

}  // namespace mote::server
