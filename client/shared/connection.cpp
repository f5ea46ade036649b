// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/connection.h"

#include "client/shared/connection_impl.h"

namespace mote::client {
namespace {

/// Hands one field of an answer to a typed reply.
template <class T, class Field>
auto typed(Connection::Reply<T> reply, Field field) {
    return [reply = std::move(reply), field](Result<proto::ServerMessage> answer) {
        if (!reply) return;
        if (!answer.ok()) return reply(answer.error());
        reply(std::move(*((*answer).*field)()));
    };
}

}  // namespace

Connection::Connection(std::filesystem::path connectionFile, ConnectionSettings settings)
    : impl_(std::make_unique<Impl>(std::move(connectionFile), std::move(settings))) {}

Connection::~Connection() = default;

Connection::State Connection::state() const {
    return impl_->state();
}

std::optional<Error> Connection::lostReason() const {
    return impl_->lostReason();
}

proto::Welcome Connection::welcome() const {
    return impl_->welcome();
}

ConnectionStatistics Connection::statistics() const {
    return impl_->statistics();
}

void Connection::reconnect() {
    impl_->reconnect();
}

std::size_t Connection::poll() {
    return impl_->poll();
}

bool Connection::wait(std::chrono::milliseconds timeout) {
    return impl_->wait(timeout);
}

std::uint64_t Connection::setView(proto::View view, const ViewRequest& request) {
    return impl_->setView(std::move(view), request);
}

std::optional<ReceivedFrame> Connection::takeFrame() {
    return impl_->takeFrame();
}

void Connection::listDatasets(Reply<proto::Catalogue> reply) {
    proto::ClientMessage question;
    question.mutable_list_datasets();
    impl_->ask(std::move(question), proto::ServerMessage::kCatalogue,
               typed(std::move(reply), &proto::ServerMessage::mutable_catalogue));
}

void Connection::describe(const std::string& dataset, Reply<proto::Description> reply) {
    proto::ClientMessage question;
    question.mutable_describe()->set_dataset(dataset);
    impl_->ask(std::move(question), proto::ServerMessage::kDescription,
               typed(std::move(reply), &proto::ServerMessage::mutable_description));
}

void Connection::submitJob(const proto::JobRequest& job, Reply<proto::JobStatus> reply) {
    proto::ClientMessage question;
    *question.mutable_submit_job()->mutable_job() = job;
    impl_->ask(std::move(question), proto::ServerMessage::kJob,
               typed(std::move(reply), &proto::ServerMessage::mutable_job));
}

void Connection::cancelJob(const std::string& id, Reply<proto::JobStatus> reply) {
    proto::ClientMessage question;
    question.mutable_cancel_job()->set_id(id);
    impl_->ask(std::move(question), proto::ServerMessage::kJob,
               typed(std::move(reply), &proto::ServerMessage::mutable_job));
}

void Connection::watchJobs(Reply<proto::Jobs> reply) {
    proto::ClientMessage question;
    question.mutable_watch_jobs();
    impl_->ask(std::move(question), proto::ServerMessage::kJobs,
               typed(std::move(reply), &proto::ServerMessage::mutable_jobs));
}

void Connection::ping(Reply<double> reply) {
    proto::ClientMessage question;
    question.mutable_ping();
    impl_->ask(std::move(question), proto::ServerMessage::kPong,
               [this, reply = std::move(reply)](const Result<proto::ServerMessage>& answer) {
                   if (!reply) return;
                   answer.ok() ? reply(impl_->statistics().roundTripMs) : reply(answer.error());
               });
}

void Connection::onState(std::function<void(State)> listener) {
    impl_->stateListener = std::move(listener);
}

void Connection::onCatalogue(std::function<void(const proto::Catalogue&)> listener) {
    impl_->catalogueListener = std::move(listener);
}

void Connection::onJob(std::function<void(const proto::JobStatus&)> listener) {
    impl_->jobListener = std::move(listener);
}

void Connection::onViewFailed(std::function<void(std::uint64_t, const Error&)> listener) {
    impl_->viewListener = std::move(listener);
}

}  // namespace mote::client
