// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/session.h"

#include <fmt/format.h>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>

#include "protocol/base/utf8.h"
#include "server/log.h"

namespace mote::server {
Session::Session(SessionId id, wire::MessageStream stream, SessionContext& context, Role role)
    : id_(id),
      context_(context),
      role_(role),
      executor_(stream.executor()),
      stream_(std::move(stream)),
      deadline_(executor_),
      lookAt_(executor_),
      readerWake_(executor_),
      workerWake_(executor_),
      writerWake_(executor_),
      answersWake_(executor_),
      frames_(std::make_shared<FrameSender>(id, executor_, *context.render, context.crashes, outbox_,
                                            [this] { writerWake_.notify(); })),
      commandAccount_(maxCommandBytes, context.datasets->budget()),
      queries_(context.queries, executor_, context.datasets->budget()),
      thumbnails_(context.thumbnails, executor_),
      uploads_(std::make_shared<Uploads>(context.uploads, context.removeUploads)) {}

void Session::start(const proto::ClientMessage& hello, const ParkedSessions::Admission& admission) {
    welcome(hello, admission);
    for (const auto coroutine : {&Session::read, &Session::work, &Session::write, &Session::handOnAnswers}) {
        asio::co_spawn(
            executor_, [self = shared_from_this(), coroutine] { return self->runOrClose(coroutine); },
            asio::detached);
    }
}

/// Whatever of our own is broken: this connection ends, the server goes on.
asio::awaitable<void> Session::runOrClose(asio::awaitable<void> (Session::*coroutine)()) {
    try {
        co_await (this->*coroutine)();
    } catch (const std::exception& failure) {
        log::failure("a session cannot go on", failure);
        close();
    }
}

// --------------------------------------------------------------------------------------------- reading

asio::awaitable<void> Session::read() {
    co_await goOn();
    std::vector<std::uint8_t> payload;
    while (!leaving_ && !closed_) {
        // A client that does not take its replies is not asked for more.
        while (!outbox_.room() && !closed_) co_await readerWake_.wait();
        if (closed_) co_return;
        proto::ClientMessage message;
        const auto status = co_await stream_.read(message, payload, wire::clientLimits);
        if (!status.ok()) co_return leave(status.error());
        context_.parked->confirm(id_);  // it answers a welcome
        life_.heard(message, Clock::now());
        co_await handle(std::move(message));
    }
}

void Session::welcome(const proto::ClientMessage& message, const ParkedSessions::Admission& admission) {
    context_.metrics->sessions.add();
    log::info(log::session(id_), "\"{}\" connected{}", toLogText(message.hello().client()),
              admission.resumed ? fmt::format(" and goes on from session {}", admission.before) : "");
    frames_->open(message.hello());
    life_ = ClientLife(message.hello(), context_.silence, context_.idle, Clock::now());
    lookLater();
    proto::ServerMessage reply;
    auto& welcome = *reply.mutable_welcome();
    welcome.set_server(context_.server);
    welcome.set_minor(wire::ownVersion.minor);
    welcome.set_device(toUtf8(context_.device));
    welcome.set_frame_credits(frameCredits(message.hello()));
    welcome.set_resume(admission.secret);
    welcome.set_resumed(admission.resumed);
    welcome.set_session(id_);
    welcome.set_follower(role_ == Role::follower);
    welcome.set_silence_ms(static_cast<std::uint32_t>(context_.silence.count()));
    if (const auto& view = admission.state.view) {
        *welcome.mutable_view() = *view;
        resumedView_.emplace();
        resumedView_->set_request(message.request());
        *resumedView_->mutable_set_view() = *view;
    }
    this->reply(message.request(), std::move(reply));
    if (admission.state.uploads) uploads_ = admission.state.uploads;
    context_.parked->setUploads(id_, uploads_);
    watchesJobs_ = admission.state.watchesJobs;
    if (watchesJobs_) outbox_.allJobsChanged();
}

/// With what the session was about when its line broke.
asio::awaitable<void> Session::goOn() {
    const auto view = std::exchange(resumedView_, std::nullopt);
    if (view) co_await setView(view->request(), view->set_view());
}

asio::awaitable<void> Session::handle(proto::ClientMessage message) {
    using Body = proto::ClientMessage;
    const std::uint64_t request = message.request();
    if (const auto may = allowed(role_, message); !may.ok()) co_return refuse(request, may.error());
    switch (message.body_case()) {
        case Body::kSetView:
            co_await setView(request, message.set_view());
            break;
        case Body::kCredit:
            if (const auto taken = frames_->returned(message.credit()); !taken.ok()) leave(taken.error());
            break;
        case Body::kPing: {
            proto::ServerMessage pong;
            pong.mutable_pong()->set_sent_ns(message.ping().sent_ns());
            reply(request, std::move(pong));
            break;
        }
        case Body::kPong:
            break;  // its bytes were all that was asked for
        case Body::kListSessions:
            listSessions(request);
            break;
        case Body::kFollow:
            follow(request, message.follow().session());
            break;
        case Body::kQuery:
            co_await query(std::move(message));
            break;
        case Body::kGetThumbnail:
            co_await thumbnail(request, message.get_thumbnail().dataset());
            break;
        case Body::kLookAtFile:
            lookAtFile(request, message.look_at_file());
            break;
        case Body::kCancelQuery:
            queries_.cancel(message.cancel_query().request());
            cancelLook(message.cancel_query().request());
            answersWake_.notify();
            break;
        case Body::kHello:
            leave({ErrorCode::invalidArgument, "hello", "it was said already"});
            break;
        case Body::BODY_NOT_SET:
            // A newer minor version may know more than we do.
            refuse(request, {ErrorCode::unsupported, "message", "it is not known here"});
            break;
        default:
            while (!commandsHaveRoom() && !closed_) co_await readerWake_.wait();
            auto hold = commandAccount_.hold(message.SpaceUsedLong());
            commands_.push_back({std::move(message), std::move(hold)});
            workerWake_.notify();
    }
}

// --------------------------------------------------------------------------------------------- writing

asio::awaitable<void> Session::write() {
    const Outbox::Piece pieces = [this](const RenderedFrame& frame, std::size_t begin, std::size_t left) {
        return frames_->piece(frame, begin, left);
    };
    while (!closed_) {
        frames_->dropStale(context_.staleAfter);
        auto item = outbox_.next(pieces);
        if (!item) {
            co_await writerWake_.wait();
            continue;
        }
        readerWake_.notify();
        if (item->kind == Outbox::Item::Kind::allJobs) {
            co_await askJobs(0, allJobs);
            continue;
        }
        fill(*item);
        std::span<const std::uint8_t> payload = item->payload;
        if (item->frame) payload = std::span(item->frame->payload).subspan(item->begin, item->size);
        const auto status = co_await stream_.write(item->message, payload, wire::serverLimits);
        if (status.ok()) context_.metrics->countSent(item->message, payload.size());
        life_.told(item->message, Clock::now());
        if (!status.ok() && status.error().code == ErrorCode::resourceExhausted) {
            // Nothing of it went out: the client hears why instead.
            outbox_.reply(failureMessage(item->message.reply_to(), status.error(), false));
        } else if (!status.ok() || item->kind == Outbox::Item::Kind::farewell) {
            if (status.ok() && !closed_) co_await stream_.finish();
            close();
        }
    }
}

/// Takes the present state of what changed.
void Session::fill(Outbox::Item& item) {
    using Kind = Outbox::Item::Kind;
    if (item.kind == Kind::catalogue) {
        *item.message.mutable_catalogue() = *context_.datasets->catalogue();
    } else if (item.kind == Kind::job) {
        *item.message.mutable_job() = *item.job;
    } else if (item.kind == Kind::followed) {
        *item.message.mutable_followed() = followed_;
        item.message.set_reply_to(std::exchange(followReply_, 0));
    } else if (item.kind == Kind::frame) {
        frames_->fill(item);
    }
}

void Session::reply(std::uint64_t to, Reply reply) {
    constexpr std::size_t large = 64 << 10;  // smaller ones are part of what the program may take
    reply.message.set_reply_to(to);
    if (const auto bytes = reply.bytes(); bytes >= large)
        reply.held = HeldMemory::of(context_.datasets->budget(), bytes);
    outbox_.reply(std::move(reply));
    writerWake_.notify();
}

void Session::refuse(std::uint64_t to, const Error& error) {
    reply(to, failureMessage(to, error, false));
}

void Session::catalogueChanged() {
    outbox_.catalogueChanged();
    writerWake_.notify();
}

void Session::jobChanged(std::shared_ptr<const proto::JobStatus> job) {
    if (!watchesJobs_) return;
    outbox_.jobChanged(std::move(job));
    writerWake_.notify();
}

// ---------------------------------------------------------------------------------------------- ending

void Session::lookLater() {
    const auto wait = life_.interval();
    if (wait.count() == 0) return;
    lookAt_.expires_after(wait);
    lookAt_.async_wait([weak = weak_from_this()](const asio::error_code& code) {
        const auto self = weak.lock();
        if (!code && self && !self->closed_ && !self->leaving_) self->look();
    });
}

void Session::look() {
    const auto found = life_.at(Clock::now(), stream_.progress());
    if (found.end) return leave(*found.end);
    if (found.ask) {
        proto::ServerMessage ping;
        ping.mutable_ping();
        reply(0, std::move(ping));
    }
    lookLater();
}

void Session::leave(const Error& reason) {
    if (leaving_ || closed_) return;
    const bool gone = reason.code == ErrorCode::cancelled && reason.where == "connection";
    if (gone) return close();
    leaving_ = true;
    log::info(log::session(id_), "closed: {}", toLogText(reason.toString()));
    frames_->close();
    queries_.close();
    thumbnails_.close();
    endLook();
    outbox_.farewell(failureMessage(0, reason, true));
    writerWake_.notify();
    workerWake_.notify();
    deadline_.expires_after(context_.farewellTimeout);
    deadline_.async_wait([weak = weak_from_this()](const asio::error_code& code) {
        const auto self = weak.lock();
        if (!code && self) self->close();
    });
}

void Session::close() {
    if (std::exchange(closed_, true)) return;
    // Who was told why it ends has its line in the log.
    if (!std::exchange(leaving_, true)) log::info(log::session(id_), "left");
    stream_.close();
    frames_->close();
    deadline_.cancel();
    lookAt_.cancel();
    readerWake_.notify();
    workerWake_.notify();
    writerWake_.notify();
    answersWake_.notify();
    queries_.close();
    thumbnails_.close();
    endLook();
    context_.closed(id_);
}

}  // namespace mote::server
