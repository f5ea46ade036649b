// SPDX-License-Identifier: GPL-3.0-or-later
//
// The owner's side: what any thread may call. The I/O thread's side is in connection_io.cpp.
#include "client/shared/connection_impl.h"

#include <fmt/format.h>

#include <asio/post.hpp>

#include "protocol/wire/limits.h"

namespace mote::client {
namespace {

/// More unanswered questions than this are an owner's mistake, or a server that answers nothing.
constexpr std::size_t maxQuestions = 1024;

/// Whether a server takes it, with the few bytes around it.
bool fits(const google::protobuf::MessageLite& message) {
    return message.ByteSizeLong() <= wire::clientLimits.message - 64;
}

std::int64_t nowNs() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

}  // namespace

Connection::Impl::Impl(std::filesystem::path connectionFile, ConnectionSettings settings)
    : connectionFile_(std::move(connectionFile)), settings_(std::move(settings)) {
    asio::post(context_, [this] { connect(); });
    thread_ = std::thread([this] { context_.run(); });
}

Connection::Impl::~Impl() {
    // Everything under way is aborted and ends by itself: no coroutine is left to be destroyed with the
    // context.
    asio::post(context_, [this] {
        ending_ = true;
        if (line_) line_->close();
        line_.reset();
        timer_.cancel();
        work_.reset();
    });
    thread_.join();
}

Connection::State Connection::Impl::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

std::optional<Error> Connection::Impl::lostReason() const {
    const std::lock_guard lock(mutex_);
    return lostReason_;
}

proto::Welcome Connection::Impl::welcome() const {
    const std::lock_guard lock(mutex_);
    return welcome_;
}

ConnectionStatistics Connection::Impl::statistics() const {
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mutex_);
    auto statistics = totals_;
    statistics.framesPerSecond = frameRate_.perSecond(now);
    statistics.bytesPerSecond = byteRate_.perSecond(now);
    if (pingSince_) {
        const std::chrono::duration<double, std::milli> waiting = now - *pingSince_;
        statistics.roundTripMs = std::max(statistics.roundTripMs, waiting.count());
    }
    return statistics;
}

void Connection::Impl::reconnect() {
    {
        const std::lock_guard lock(mutex_);
        setState(State::connecting);
    }
    notify();
    asio::post(context_, [this] {
        returning_.reset();
        connect();
    });
}

std::size_t Connection::Impl::poll() {
    std::deque<Inbox::Entry> due;
    {
        const std::lock_guard lock(mutex_);
        due = inbox_.takeAll();
    }
    for (auto& entry : due) entry.callback();
    return due.size();
}

bool Connection::Impl::wait(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, timeout, [&] { return !inbox_.empty() || frame_.has_value(); });
}

std::uint64_t Connection::Impl::setView(proto::View view, const ViewRequest& request) {
    std::uint64_t id = 0;
    {
        const std::lock_guard lock(mutex_);
        id = ++lastViewId_;
        WantedView wanted;
        *wanted.message.mutable_view() = std::move(view);
        wanted.message.set_view_id(id);
        wanted.message.set_final_only(request.finalOnly);
        wanted.message.set_format(request.format);
        wanted.message.set_asked_ns(nowNs());
        wanted.message.set_moving(request.moving);
        if (request.page) *wanted.message.mutable_page() = *request.page;
        if (fits(wanted.message)) {
            view_ = std::move(wanted);
        } else {
            viewFailed(id, {ErrorCode::invalidArgument, "", "the view is larger than a server accepts"});
        }
    }
    wakeWriter();
    return id;
}

std::optional<ReceivedFrame> Connection::Impl::takeFrame() {
    std::optional<ReceivedFrame> frame;
    {
        const std::lock_guard lock(mutex_);
        if (!frame_) return std::nullopt;
        frame = std::exchange(frame_, std::nullopt);
        giveBackFrame();
    }
    wakeWriter();
    return frame;
}

void Connection::Impl::ask(proto::ClientMessage question, Body expected, Answer answer) {
    {
        const std::lock_guard lock(mutex_);
        const auto refuse = [&](Error error) {
            push({}, [answer = std::move(answer), error = std::move(error)] { answer(error); });
        };
        if (state_ == State::lost) {
            refuse(lostReason_.value_or(Error{}));
        } else if (questions_.size() >= maxQuestions) {
            refuse({ErrorCode::resourceExhausted, "", "too many questions to the server are unanswered"});
        } else if (!fits(question)) {
            refuse({ErrorCode::invalidArgument, "", "the request is larger than a server accepts"});
        } else {
            question.set_request(++lastRequest_);
            outbox_.push_back(question);
            questions_[lastRequest_] = {expected, std::move(answer), std::move(question)};
        }
    }
    notify();
    wakeWriter();
}

void Connection::Impl::wakeWriter() {
    asio::post(context_, [this] {
        if (line_) line_->wakeWriter();
    });
}

void Connection::Impl::notify() {
    changed_.notify_all();
    if (settings_.wake) settings_.wake();
}

// With mutex_ held -------------------------------------------------------------------------------------

void Connection::Impl::push(std::string key, Inbox::Callback callback) {
    inbox_.push(std::move(key), std::move(callback));
}

void Connection::Impl::setState(State state) {
    state_ = state;
    if (state != State::lost) lostReason_.reset();
    push("state", [this, state] {
        if (stateListener) stateListener(state);
    });
}

void Connection::Impl::giveBackFrame() {
    credit_.set_frames(credit_.frames() + 1);
    creditDue_ = true;
}

void Connection::Impl::failAll(const Error& reason) {
    outbox_.clear();
    for (auto& [request, question] : questions_) question.sent = true;
    failSent(reason);
}

void Connection::Impl::failSent(const Error& reason) {
    std::erase_if(questions_, [&](auto& entry) {
        auto& question = entry.second;
        if (question.sent) push({}, [answer = std::move(question.answer), reason] { answer(reason); });
        return question.sent;
    });
}

/// Asks everything again but for jobs that were sent: nobody knows whether they were submitted.
void Connection::Impl::askAgain(const Error& reason) {
    for (auto& [request, question] : questions_)
        question.sent = question.sent && question.message.has_submit_job();
    failSent(reason);
    outbox_.clear();
    for (const auto& [request, question] : questions_) outbox_.push_back(question.message);
}

void Connection::Impl::viewFailed(std::uint64_t viewId, const Error& error) {
    push(fmt::format("view {}", viewId), [this, viewId, error] {
        if (viewListener) viewListener(viewId, error);
    });
}

std::uint64_t Connection::Impl::viewOfRequest(std::uint64_t request) const {
    for (const auto& [sent, viewId] : sentViews_) {
        if (sent == request) return viewId;
    }
    return 0;
}

}  // namespace mote::client
