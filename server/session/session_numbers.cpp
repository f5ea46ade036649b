// SPDX-License-Identifier: GPL-3.0-or-later
//
// A session's questions for numbers: from the message to the query service and back.
#include "server/session/session.h"

namespace mote::server {

/// A dataset that was published a moment ago may not be known yet: only then is the disk asked first.
asio::awaitable<void> Session::query(proto::ClientMessage message) {
    auto& query = *message.mutable_query();
    auto found = success();
    if (!query.dataset().empty() && !context_.datasets->contains(query.dataset()))
        found = co_await rescan(readerWake_);
    if (closed_) co_return;
    if (!found.ok()) co_return reply(message.request(), failureMessage(0, found.error(), false));
    const auto ready = [weak = weak_from_this()] {
        if (const auto self = weak.lock()) self->answersWake_.notify();
    };
    const auto taken = queries_.ask(message.request(), std::move(query), ready);
    if (!taken.ok()) reply(message.request(), failureMessage(0, taken.error(), false));
}

asio::awaitable<void> Session::handOnAnswers() {
    while (!closed_ && !leaving_) {
        // The writer wakes readers and workers alike when there is room again.
        while (!outbox_.room() && !closed_) co_await readerWake_.wait();
        if (closed_) co_return;
        auto answered = queries_.take();
        if (!answered) {
            co_await answersWake_.wait();
            continue;
        }
        if (!answered->answer.ok()) {
            reply(answered->request, failureMessage(0, answered->answer.error(), false));
            continue;
        }
        proto::ServerMessage text;
        *text.mutable_answer() = std::move(answered->answer->message);
        reply(answered->request, Reply(std::move(text), std::move(answered->answer->payload)));
    }
}

}  // namespace mote::server
