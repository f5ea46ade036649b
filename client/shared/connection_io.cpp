// SPDX-License-Identifier: GPL-3.0-or-later
//
// The I/O thread's side of a connection.
#include <fmt/format.h>

#include <algorithm>
#include <asio/post.hpp>

#include "client/shared/connection_impl.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/wire/framing.h"

namespace mote::client {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// Requests whose view is remembered: a failure answers one of the latest.
constexpr std::size_t rememberedViews = 64;

/// Since a time of our own that the server echoed; nothing it sends back can make it negative.
double msSince(std::int64_t ns, Clock::time_point now) {
    const Clock::time_point then{std::chrono::nanoseconds(ns)};
    return then > now ? 0.0 : Milliseconds(now - then).count();
}

}  // namespace

std::optional<proto::ClientMessage> Connection::Impl::next() {
    const std::lock_guard lock(mutex_);
    if (hello_) {
        hello_->set_request(++lastRequest_);
        return std::exchange(hello_, std::nullopt);
    }
    if (!welcomed_) return std::nullopt;
    if (pong_) return std::exchange(pong_, std::nullopt);
    if (creditDue_) return nextCredit();
    return outbox_.empty() ? nextView() : nextQuestion();
}

std::optional<proto::ClientMessage> Connection::Impl::nextCredit() {
    proto::ClientMessage message;
    message.set_request(++lastRequest_);
    *message.mutable_credit() = std::exchange(credit_, {});
    creditDue_ = false;
    return message;
}

proto::ClientMessage Connection::Impl::nextQuestion() {
    auto message = std::move(outbox_.front());
    outbox_.pop_front();
    if (const auto question = questions_.find(message.request()); question != questions_.end())
        question->second.sent = true;
    if (message.has_ping()) message.mutable_ping()->set_sent_ns(Clock::now().time_since_epoch().count());
    return message;
}

/// The first one that may be sent now; null where there is none.
Connection::Impl::WantedView* Connection::Impl::unsentView() {
    if (view_ && !view_->sent) return &*view_;
    // An older server knows no queue: it gets one at a time.
    const std::size_t most = welcome_.minor() >= 2 ? wire::maxQueuedViews : 1;
    for (std::size_t i = 0; i < std::min(queuedViews_.size(), most); ++i) {
        if (!queuedViews_[i].sent) return &queuedViews_[i];
    }
    return nullptr;
}

std::optional<proto::ClientMessage> Connection::Impl::nextView() {
    auto* const view = unsentView();
    if (view == nullptr) return std::nullopt;
    view->sent = true;
    proto::ClientMessage message;
    message.set_request(++lastRequest_);
    *message.mutable_set_view() = view->message;
    sentViews_.emplace_back(lastRequest_, view->message.view_id());
    if (sentViews_.size() > rememberedViews) sentViews_.pop_front();
    return message;
}

void Connection::Impl::received(proto::ServerMessage message, std::vector<std::uint8_t> payload) {
    {
        const std::lock_guard lock(mutex_);
        const auto size = message.ByteSizeLong() + payload.size();
        byteRate_.add(Clock::now(), static_cast<double>(size));
        totals_.bytes += size;
    }
    if (!welcomed_) return welcomed(message);
    switch (message.body_case()) {
        case proto::ServerMessage::kFrame:
            return receivedPiece(std::move(*message.mutable_frame()), std::move(payload));
        case proto::ServerMessage::kFailure:
            return receivedFailure(message);
        default:
            return answered(std::move(message), std::move(payload));
    }
}

/// The receipt goes out before the picture is decoded, so that the server measures the link and not us.
void Connection::Impl::receivedPiece(proto::Frame message, std::vector<std::uint8_t> payload) {
    receivedBytes_ += payload.size();
    {
        const std::lock_guard lock(mutex_);
        totals_.pictureBytes += payload.size();
    }
    if (saysReceipts_) {
        const std::lock_guard lock(mutex_);
        credit_.set_received_bytes(receivedBytes_);
        creditDue_ = true;
    }
    const std::uint64_t viewId = message.view_id();
    auto whole = assembly_.add(std::move(message), std::move(payload));
    line_->wakeWriter();
    if (!whole.ok()) return frameFailed(viewId, whole.error());
    if (!*whole) return;
    asio::post(context_, [this, line = std::weak_ptr(line_), frame = **std::move(whole)]() mutable {
        if (line_ && line.lock() == line_) receivedFrame(std::move(frame));
    });
}

void Connection::Impl::receivedFrame(WholeFrame whole) {
    ReceivedFrame frame;
    frame.payloadBytes = whole.payload.size();
    const auto start = Clock::now();
    auto pixels = decoder_->decode(whole.message, whole.payload);  // outside the lock: it takes milliseconds
    const auto now = Clock::now();
    if (!pixels.ok()) return frameFailed(whole.message.view_id(), pixels.error());
    frame.message = std::move(whole.message);
    frame.payload = std::move(whole.payload);
    frame.pixels = *std::move(pixels);
    frame.decodeMs = Milliseconds(now - start).count();
    frame.latencyMs = msSince(frame.message.asked_ns(), now);
    {
        const std::lock_guard lock(mutex_);
        frameRate_.add(now, 1.0);
        ++totals_.frames;
        if (frame.message.link_bytes_per_second() > 0.0) {
            totals_.linkBytesPerSecond = frame.message.link_bytes_per_second();
        }
        keepFrame(std::move(frame));
    }
    line_->wakeWriter();
    notify();
}

/// A frame that only misses one before it is passed over in silence: the one that was damaged was told.
void Connection::Impl::frameFailed(std::uint64_t viewId, const Error& error) {
    {
        const std::lock_guard lock(mutex_);
        giveBackFrame();
        credit_.set_key_wanted(decoder_->wantsKey());
        if (error.code != ErrorCode::cancelled) viewFailed(viewId, error);
    }
    line_->wakeWriter();
    notify();
}

void Connection::Impl::receivedFailure(const proto::ServerMessage& message) {
    const Error error = toError(message.failure());
    if (message.failure().fatal()) return heardFarewell(error);
    {
        const std::lock_guard lock(mutex_);
        const auto question = questions_.find(message.reply_to());
        if (cancelledQueries_.erase(message.reply_to()) > 0) {
            // Its owner knows.
        } else if (question == questions_.end()) {
            viewFailed(viewOfRequest(message.reply_to()), error);
        } else {
            push({}, [answer = std::move(question->second.answer), error] { answer(error); });
            questions_.erase(question);
        }
    }
    notify();
}

void Connection::Impl::answered(proto::ServerMessage message, std::vector<std::uint8_t> payload) {
    if (message.has_ping()) return receivedPing(message.ping());
    if (message.has_pong()) {
        const std::lock_guard lock(mutex_);
        totals_.roundTripMs = msSince(message.pong().sent_ns(), Clock::now());
        pingSince_.reset();
    }
    {
        const std::lock_guard lock(mutex_);
        const auto question = questions_.find(message.reply_to());
        if (message.reply_to() != 0 && question != questions_.end()) {
            Result<ServerAnswer> result =
                Error{ErrorCode::internal, "", "the server answered something else"};
            if (message.body_case() == question->second.expected)
                result = ServerAnswer{std::move(message), std::move(payload)};
            answerQuestion(question->first, std::move(result));
        } else {
            if (message.answer().last()) cancelledQueries_.erase(message.reply_to());
            receivedNews(std::move(message));
        }
    }
    notify();
}

void Connection::Impl::receivedPing(const proto::Ping& ping) {
    {
        const std::lock_guard lock(mutex_);
        pong_.emplace();
        pong_->set_request(++lastRequest_);
        pong_->mutable_pong()->set_sent_ns(ping.sent_ns());
    }
    line_->wakeWriter();
}

void Connection::Impl::answerQuestion(std::uint64_t request, Result<ServerAnswer> result) {
    auto& question = questions_.at(request);
    const bool more = result.ok() && result->message.has_answer() && !result->message.answer().last();
    question.begun = true;
    push({}, [answer = question.answer, result = std::move(result)]() mutable { answer(std::move(result)); });
    if (!more) questions_.erase(request);
}

void Connection::Impl::receivedNews(proto::ServerMessage message) {
    if (message.has_catalogue()) {
        push("catalogue", [this, catalogue = std::move(*message.mutable_catalogue())] {
            if (catalogueListener) catalogueListener(catalogue);
        });
    }
    if (message.has_job()) {
        push("job " + message.job().id(), [this, job = std::move(*message.mutable_job())] {
            if (jobListener) jobListener(job);
        });
    }
    if (!message.has_jobs()) return;
    for (auto& changed : *message.mutable_jobs()->mutable_jobs()) {
        push("job " + changed.id(), [this, job = std::move(changed)] {
            if (jobListener) jobListener(job);
        });
    }
}

}  // namespace mote::client
