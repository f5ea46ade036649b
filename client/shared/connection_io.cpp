// SPDX-License-Identifier: GPL-3.0-or-later
//
// The I/O thread's side of a connection.
#include <fmt/format.h>
#include <algorithm>
#include <asio/post.hpp>

#include "client/shared/connection_impl.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
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

/// Servers of this minor version and above know hidden layers.
constexpr std::uint32_t hidesFromMinor = 4;

/// For a server that would draw them: the same is seen.
void fadeHidden(proto::View& view) {
    for (auto& layer : *view.mutable_layers()) {
        if (layer.hidden()) layer.set_opacity(0.0);
    }
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

/// The first one that may be sent now; null if there is none.
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
    if (welcome_.minor() < hidesFromMinor) fadeHidden(*message.mutable_set_view()->mutable_view());
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
        if (!questions_.contains(message.reply_to())) return;  // nobody else asked
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

namespace {

// How a connection's line is opened, kept alive, and opened again where it broke.

/// The pause between two attempts to open a line that broke: at first, and after a long time.
constexpr std::chrono::milliseconds returnPause{20}, longReturnPause{10'000};
/// In between it is this share of the time that the line is broken.
constexpr int returnPauseShare = 20;
/// A line that broke sooner than this after it was opened again counts as not opened: some end takes us on
/// and drops us again and again.
constexpr std::chrono::seconds holdsAfter{1};
/// For so long at most a server that has no place is asked for one by who was not there before.
constexpr std::chrono::milliseconds entryPatience{2000};

/// The server takes nobody on at the moment.
bool noPlace(const Error& error) {
    return error.code == ErrorCode::resourceExhausted && error.where == "server";
}

}  // namespace

void Connection::Impl::connect() {
    prepareLine();
    const auto server = wire::readConnectionFile(connectionFile_);
    if (!server.ok()) return lost(server.error());
    openLine(*server);
}

void Connection::Impl::prepareLine() {
    if (line_) line_->close();
    line_.reset();
    welcomed_ = false;
    saysReceipts_ = false;
    receivedBytes_ = 0;
    assembly_ = {};
    decoder_.emplace();
    {
        const std::lock_guard lock(mutex_);
        if (state_ != State::connecting) setState(State::connecting);
        if (returning_) {
            askAgain(returning_->reason);
        } else {
            // What was not sent yet waits for this connection; what an earlier one was asked is lost with it.
            failSent({ErrorCode::internal, "", "the connection was given up for a new one"});
            welcome_.Clear();
        }
        frame_.reset();
        staleFrames_ = queuedFrames_.size();
        credit_.Clear();
        creditDue_ = false;
        pong_.reset();
        sentViews_.clear();
        cancelledQueries_.clear();
        pingSince_.reset();
        if (view_) view_->sent = false;
        for (auto& view : queuedViews_) view.sent = false;
    }
}

/// A line broke, or was not opened.
void Connection::Impl::lost(const Error& reason) {
    const bool mayReturn =
        reason.code == ErrorCode::internal || reason.code == ErrorCode::notFound || noPlace(reason);
    mayReturn ? returnFrom(reason) : drop(reason);
}

/// The server ends the line and says why: mostly for good.
void Connection::Impl::heardFarewell(const Error& reason) {
    // A server that is started anew listens a moment before its connection file holds its token.
    if (reason.code == ErrorCode::permissionDenied && returning_) return returnFrom(returning_->reason);
    const bool cancelled = reason.code == ErrorCode::cancelled;
    const bool slept = cancelled && reason.where == "silence";  // this machine, or the network
    const bool ended = cancelled && reason.where == "server" && settings_.outlastsFarewells;
    noPlace(reason) || slept || ended ? returnFrom(reason) : drop(reason);
}

/// Takes the reason by value: it may be the one that is kept here.
void Connection::Impl::returnFrom(Error reason) {
    const auto now = Clock::now();
    if (welcomed_ && now - welcomedAt_ > holdsAfter) returning_.reset();
    if (!returning_ && welcomed_) returning_ = Returning{reason, now, now + settings_.returnPatience};
    if (!returning_ && noPlace(reason)) {
        returning_ = Returning{reason, now, now + std::min(entryPatience, settings_.returnPatience)};
    }
    if (!returning_) return drop(reason);
    if (now >= returning_->until) return drop(returning_->reason);
    comeBack();
}

void Connection::Impl::comeBack() {
    if (line_) line_->close();
    line_.reset();
    welcomed_ = false;
    {
        const std::lock_guard lock(mutex_);
        if (state_ != State::connecting) setState(State::connecting);
        brokenBy_ = returning_->reason;
    }
    notify();
    const auto share = (Clock::now() - returning_->since) / returnPauseShare;
    timer_.expires_after(std::clamp<Clock::duration>(share, returnPause, longReturnPause));
    timer_.async_wait([this](const asio::error_code& code) {
        if (!code && !ending_ && !line_) connect();
    });
}

void Connection::Impl::openLine(const proto::ConnectionFile& server) {
    const auto address = wire::parseAddress(server.address());
    if (!address.ok()) return lost(address.error());
    hello_.emplace();
    auto& hello = *hello_->mutable_hello();
    hello.set_token(server.token());
    hello.set_client(settings_.client);
    hello.set_minor(wire::ownVersion.minor);
    hello.set_receipts(true);
    hello.set_background(settings_.background);
    hello.set_resume(resume_);
    if (H264Decoder::available()) hello.add_decodes(proto::Frame::H264);
    LineHandlers handlers;
    handlers.next = [this] { return next(); };
    handlers.received = [this](proto::ServerMessage message, std::vector<std::uint8_t> payload) {
        received(std::move(message), std::move(payload));
    };
    handlers.lost = [this](const Error& reason) { lost(reason); };
    line_ = std::make_shared<Line>(context_.get_executor(), std::move(handlers));
    line_->open(*address, server.certificate_fingerprint());
    watchTime(settings_.connectTimeout);
}

/// Takes the reason by value: it may be the one that goes here.
void Connection::Impl::drop(Error reason) {
    if (line_) line_->close();
    line_.reset();
    timer_.cancel();
    returning_.reset();
    {
        const std::lock_guard lock(mutex_);
        brokenBy_.reset();
        lostReason_ = reason;
        setState(State::lost);
        failAll(reason);
        pingSince_.reset();
    }
    notify();
}

void Connection::Impl::welcomed(const proto::ServerMessage& message) {
    if (message.has_failure()) return heardFarewell(toError(message.failure()));
    if (!message.has_welcome()) return;
    const auto& welcome = message.welcome();
    welcomed_ = true;
    welcomedAt_ = Clock::now();
    saysReceipts_ = welcome.minor() >= 1;
    resume_ = welcome.resume();
    silence_ = wire::Silence(std::chrono::milliseconds(welcome.silence_ms()), welcomedAt_);
    {
        const std::lock_guard lock(mutex_);
        welcome_ = welcome;
        brokenBy_.reset();
        goOnWithView(message.reply_to());
        setState(State::connected);
    }
    watchLife();
    line_->wakeWriter();
    notify();
}

/// A view that the server still has is drawn already, as if the hello had asked for it. A newer one of ours
/// takes its place.
void Connection::Impl::goOnWithView(std::uint64_t hello) {
    if (!welcome_.resumed() || !view_ || welcome_.view().view_id() != view_->message.view_id()) return;
    view_->sent = true;
    sentViews_.emplace_back(hello, view_->message.view_id());
}

void Connection::Impl::watchTime(std::chrono::milliseconds wait) {
    timer_.expires_after(wait);
    timer_.async_wait([this, line = std::weak_ptr(line_)](const asio::error_code& code) {
        // A timer of an earlier line may already be on its way here.
        if (!code && line_ && line.lock() == line_) tick();
    });
}

/// As often as the round trip is measured and silence is looked for; a clock that nobody needs stands.
void Connection::Impl::watchLife() {
    const auto ping = settings_.pingInterval, silence = silence_.interval();
    const auto wait =
        ping.count() == 0 || silence.count() == 0 ? std::max(ping, silence) : std::min(ping, silence);
    if (wait.count() == 0) {
        timer_.cancel();
    } else {
        watchTime(wait);
    }
}

void Connection::Impl::tick() {
    if (!welcomed_) return lost({ErrorCode::internal, "", "the server did not answer in time"});
    const auto now = Clock::now();
    const auto verdict = silence_.at(now, line_->progress());
    if (verdict == wire::Silence::Verdict::gone) {
        return lost(
            {ErrorCode::internal, "",
             fmt::format("nothing was heard of the server for {:.3g} s", welcome_.silence_ms() / 1000.0)});
    }
    const bool measures = settings_.pingInterval.count() > 0 && now - pingedAt_ >= settings_.pingInterval;
    if (measures || verdict == wire::Silence::Verdict::ask) {
        const std::lock_guard lock(mutex_);
        if (!pingSince_) {
            pingSince_ = pingedAt_ = now;
            proto::ClientMessage ping;
            ping.mutable_ping();
            ping.set_request(++lastRequest_);
            outbox_.push_back(std::move(ping));
        }
    }
    line_->wakeWriter();
    watchLife();
}

}  // namespace mote::client
