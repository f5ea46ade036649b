// SPDX-License-Identifier: GPL-3.0-or-later
//
// A connection's queries for numbers: the questions with more than one answer.
#include <algorithm>
#include <atomic>

#include "client/shared/connection_impl.h"

namespace mote::client {
namespace {

/// A server that ends none of its queries is not listened to for ever.
constexpr std::size_t mostCancelled = 1024;

}  // namespace

std::uint64_t Connection::query(const proto::Query& query, Reply<QueryAnswer> reply) {
    proto::ClientMessage question;
    *question.mutable_query() = query;
    const auto wanted = std::make_shared<std::atomic<bool>>(true);
    const auto request = impl_->ask(
        std::move(question), proto::ServerMessage::kAnswer,
        [wanted, reply = std::move(reply)](Result<Impl::ServerAnswer> answer) {
            if (!*wanted) return;
            if (!answer.ok()) return reply(answer.error());
            reply(QueryAnswer{std::move(*answer->message.mutable_answer()), std::move(answer->payload)});
        });
    const std::lock_guard lock(impl_->mutex_);
    std::erase_if(impl_->queriesWanted_, [](const auto& entry) { return entry.second.expired(); });
    impl_->queriesWanted_[request] = wanted;
    return request;
}

void Connection::cancelQuery(std::uint64_t query) {
    {
        const std::lock_guard lock(impl_->mutex_);
        const auto wanted = impl_->queriesWanted_.extract(query);
        if (const auto flag = wanted ? wanted.mapped().lock() : nullptr) *flag = false;
        const auto question = impl_->questions_.find(query);
        if (question == impl_->questions_.end()) return;
        if (question->second.sent) {
            proto::ClientMessage message;
            message.set_request(++impl_->lastRequest_);
            message.mutable_cancel_query()->set_request(query);
            impl_->outbox_.push_back(std::move(message));
            auto& cancelled = impl_->cancelledQueries_;
            cancelled.insert(query);
            if (cancelled.size() > mostCancelled) cancelled.erase(cancelled.begin());
        } else {
            std::erase_if(impl_->outbox_, [&](const auto& message) { return message.request() == query; });
        }
        impl_->questions_.erase(question);
    }
    impl_->wakeWriter();
}

}  // namespace mote::client
