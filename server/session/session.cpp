// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/session.h"

#include <fmt/format.h>

#include <asio/co_spawn.hpp>
#include <asio/post.hpp>

#include "protocol/scene/utf8.h"
#include "server/log.h"

namespace mote::server {
namespace {

proto::ServerMessage failure(const Error& error) {
    return failureMessage(0, error, false);
}

}  // namespace

Session::Session(SessionId id, wire::MessageStream stream, SessionContext& context, Role role)
    : id_(id),
      context_(context),
      role_(role),
      executor_(stream.executor()),
      stream_(std::move(stream)),
      deadline_(executor_),
      pace_(executor_),
      life_(executor_),
      readerWake_(executor_),
      workerWake_(executor_),
      writerWake_(executor_),
      answersWake_(executor_),
      commandAccount_(maxCommandBytes, context.datasets->budget()),
      queries_(context.queries, executor_, context.datasets->budget()),
      uploads_(std::make_shared<Uploads>(context.uploads, context.removeUploads)) {}

void Session::start(const proto::ClientMessage& hello, const ParkedSessions::Admission& admission) {
    try {
        welcome(hello, admission);
        spawnAll();
    } catch (...) {
        close();  // memory is short, say: nobody goes on drawing for it
        throw;
    }
}

void Session::spawnAll() {
    const auto spawn = [this](asio::awaitable<void> (Session::*coroutine)()) {
        asio::co_spawn(
            executor_, [self = shared_from_this(), coroutine] { return self->runOrClose(coroutine); },
            [self = shared_from_this()](const std::exception_ptr& failure) {
                if (failure) self->close();  // there was no memory to begin it
            });
    };
    spawn(&Session::read);
    spawn(&Session::work);
    spawn(&Session::write);
    spawn(&Session::handOnAnswers);
}

/// Memory is short, say: this connection ends, the server goes on. Not left to the handler of co_spawn(),
/// which takes memory itself.
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
        noteWish(message);
        co_await handle(std::move(message));
    }
}

void Session::welcome(const proto::ClientMessage& message, const ParkedSessions::Admission& admission) {
    context_.metrics->sessions.add();
    log::info(log::session(id_), "\"{}\" connected{}", toLogText(message.hello().client()),
              admission.resumed ? fmt::format(" and goes on from session {}", admission.before) : "");
    begin(message.hello());
    beginLife(message.hello());
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
    const auto may = allowed(message);
    if (!may.ok()) {
        reply(request, failureMessage(request, may.error(), false));
        co_return;
    }
    switch (message.body_case()) {
        case Body::kSetView:
            co_await setView(request, message.set_view());
            break;
        case Body::kCredit:
            returnCredit(message.credit());
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
        case Body::kCancelQuery:
            queries_.cancel(message.cancel_query().request());
            answersWake_.notify();
            break;
        case Body::kHello:
            leave({ErrorCode::invalidArgument, "hello", "it was said already"});
            break;
        case Body::BODY_NOT_SET:
            // A newer minor version may know more than we do.
            reply(request, failureMessage(
                               request, {ErrorCode::unsupported, "message", "it is not known here"}, false));
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
        return piece(frame, begin, left);
    };
    while (!closed_) {
        dropStaleFrames();
        auto item = outbox_.next(pieces);
        if (!item) {
            co_await writerWake_.wait();
            continue;
        }
        readerWake_.notify();
        if (item->kind == Outbox::Item::Kind::allJobs) {
            co_await askJobs(0, allJobs, writerWake_);
            continue;
        }
        fill(*item);
        std::span<const std::uint8_t> payload = item->payload;
        if (item->frame) payload = std::span(item->frame->payload).subspan(item->begin, item->size);
        const auto status = co_await stream_.write(item->message, payload, wire::serverLimits);
        if (status.ok()) context_.metrics->countSent(item->message, payload.size());
        noteNews(item->message);
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
        fillFrame(item);
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

void Session::catalogueChanged() {
    outbox_.catalogueChanged();
    writerWake_.notify();
}

void Session::jobChanged(std::shared_ptr<const proto::JobStatus> job) {
    if (!watchesJobs_) return;
    orClose([&] { outbox_.jobChanged(std::move(job)); });
    writerWake_.notify();
}

// ---------------------------------------------------------------------------------------------- ending

void Session::leave(const Error& reason) {
    if (leaving_ || closed_) return;
    const bool gone = reason.code == ErrorCode::cancelled && reason.where == "connection";
    if (gone) return close();
    leaving_ = true;
    orClose([&] { sayFarewell(reason); });
}

void Session::sayFarewell(const Error& reason) {
    log::info(log::session(id_), "closed: {}", toLogText(reason.toString()));
    context_.render->close(id_);  // nothing more is drawn or counted for it
    queries_.close();
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
    const bool told = std::exchange(leaving_, true);
    stream_.close();  // first, as it takes no memory: whatever follows, the client is not left waiting
    context_.render->close(id_);
    deadline_.cancel();
    pace_.cancel();
    life_.cancel();
    readerWake_.notify();
    workerWake_.notify();
    writerWake_.notify();
    answersWake_.notify();
    queries_.close();
    context_.closed(id_);
    // Who was told why it ends has its line in the log. Last: where memory is too short for it, all else is
    // done.
    if (!told) log::info(log::session(id_), "left");
}

void Session::closeIfInVain() {
    if (!*inVain_ || closed_) return;
    close();
    log::warn(log::session(id_), "memory was too short to answer it");
}

asio::awaitable<void> Session::work() {
    while (!leaving_ && !closed_) {
        if (commands_.empty()) {
            co_await workerWake_.wait();
            continue;
        }
        Command command = std::move(commands_.front());
        commands_.pop_front();
        readerWake_.notify();
        co_await workOn(command.message);
        command.hold = {};
        readerWake_.notify();
    }
}

/// The writer wakes readers and workers alike when there is room again.
asio::awaitable<void> Session::workOn(proto::ClientMessage& command) {
    if (auto question = jobQuestion(command)) {
        while (!outbox_.room() && !closed_) co_await readerWake_.wait();
        co_return co_await askJobs(command.request(), std::move(question), workerWake_);
    }
    auto answered = co_await answer(command);
    while (!outbox_.room() && !closed_) co_await readerWake_.wait();
    reply(command.request(), std::move(answered));
}

asio::awaitable<Reply> Session::answer(const proto::ClientMessage& command) {
    using Body = proto::ClientMessage;
    switch (command.body_case()) {
        case Body::kListDatasets:
            co_return co_await listDatasets();
        case Body::kDescribe:
            co_return co_await describe(command.describe().dataset());
        case Body::kFetchFilm:
            co_return co_await fetchFilm(command.fetch_film());
        default:
            co_return failure({ErrorCode::unsupported, "message", "it is not known here"});
    }
}

template <class Answer>
Asker<Answer> Session::asker(std::shared_ptr<std::optional<Answer>> answer, Wakeup& wake) {
    return {[weak = weak_from_this(), executor = executor_, answer = std::move(answer), &wake](Answer told) {
                asio::post(executor, [weak, answer, &wake, told = std::move(told)]() mutable {
                    answer->emplace(std::move(told));
                    if (const auto self = weak.lock()) wake.notify();
                });
            },
            [inVain = inVain_] { *inVain = true; }};
}

asio::awaitable<Status> Session::rescan(Wakeup& wake) {
    const auto answer = std::make_shared<std::optional<Status>>();
    context_.datasets->rescan(asker(answer, wake));
    while (!*answer && !closed_) co_await wake.wait();
    if (!*answer) co_return Error{ErrorCode::cancelled, "connection", "closed"};
    co_return *std::move(*answer);
}

/// What is on the disk now, not what was at the last look.
asio::awaitable<proto::ServerMessage> Session::listDatasets() {
    const auto looked = co_await rescan(workerWake_);
    if (!looked.ok()) co_return failure(looked.error());
    proto::ServerMessage message;
    *message.mutable_catalogue() = *context_.datasets->catalogue();
    co_return message;
}

asio::awaitable<proto::ServerMessage> Session::describe(const std::string& dataset) {
    const auto answer = std::make_shared<std::optional<Result<proto::Description>>>();
    context_.datasets->describe(dataset, asker(answer, workerWake_));
    while (!*answer && !closed_) co_await workerWake_.wait();
    if (!*answer) co_return failure({ErrorCode::cancelled, "connection", "closed"});
    if (!(*answer)->ok()) co_return failure((*answer)->error());
    proto::ServerMessage message;
    *message.mutable_description() = std::move((*answer)->value());
    co_return message;
}

}  // namespace mote::server
