// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/connection.h"

#include <fmt/format.h>
#include <algorithm>
#include <asio/post.hpp>
#include <atomic>

#include "client/shared/connection_impl.h"
#include "protocol/wire/framing.h"

namespace mote::client {
namespace {

/// Hands one field of an answer to a typed reply.
template <class T, class Field>
auto typed(Connection::Reply<T> reply, Field field) {
    return [reply = std::move(reply), field](auto answer) {
        if (!reply) return;
        if (!answer.ok()) return reply(answer.error());
        reply(std::move(*(answer->message.*field)()));
    };
}

/// More unanswered questions than this are an owner's mistake, or a server that answers nothing.
constexpr std::size_t maxQuestions = 1024;

/// Tells whether a server takes it, with the few bytes around it.
bool fits(const google::protobuf::MessageLite& message) {
    return message.ByteSizeLong() <= wire::clientLimits.message - 64;
}

std::int64_t nowNs() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

}  // namespace

Connection::Connection(std::filesystem::path connectionFile, ConnectionSettings settings)
    : impl_(std::make_unique<Impl>(std::move(connectionFile), std::move(settings))) {}

Connection::~Connection() = default;

Connection::State Connection::state() const {
    const std::lock_guard lock(impl_->mutex_);
    return impl_->state_;
}

std::optional<Error> Connection::lostReason() const {
    const std::lock_guard lock(impl_->mutex_);
    return impl_->lostReason_;
}

std::optional<Error> Connection::brokenBy() const {
    const std::lock_guard lock(impl_->mutex_);
    return impl_->brokenBy_;
}

proto::Welcome Connection::welcome() const {
    const std::lock_guard lock(impl_->mutex_);
    return impl_->welcome_;
}

ConnectionStatistics Connection::statistics() const {
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(impl_->mutex_);
    auto statistics = impl_->totals_;
    statistics.framesPerSecond = impl_->frameRate_.perSecond(now);
    statistics.bytesPerSecond = impl_->byteRate_.perSecond(now);
    if (impl_->pingSince_) {
        const std::chrono::duration<double, std::milli> waiting = now - *impl_->pingSince_;
        statistics.roundTripMs = std::max(statistics.roundTripMs, waiting.count());
    }
    return statistics;
}

void Connection::reconnect() {
    {
        const std::lock_guard lock(impl_->mutex_);
        impl_->setState(State::connecting);
    }
    impl_->notify();
    asio::post(impl_->context_, [impl = impl_.get()] {
        impl->returning_.reset();
        impl->connect();
    });
}

std::size_t Connection::poll() {
    std::deque<Inbox::Entry> due;
    {
        const std::lock_guard lock(impl_->mutex_);
        due = impl_->inbox_.takeAll();
    }
    for (auto& entry : due) entry.callback();
    return due.size();
}

bool Connection::wait(std::chrono::milliseconds timeout) {
    std::unique_lock lock(impl_->mutex_);
    return impl_->changed_.wait_for(lock, timeout, [&] {
        return !impl_->inbox_.empty() || impl_->frame_ || !impl_->queuedFrames_.empty();
    });
}

std::uint64_t Connection::setView(proto::View view, const ViewRequest& request) {
    std::uint64_t id = 0;
    {
        const std::lock_guard lock(impl_->mutex_);
        id = ++impl_->lastViewId_;
        Impl::WantedView wanted;
        *wanted.message.mutable_view() = std::move(view);
        wanted.message.set_view_id(id);
        wanted.message.set_final_only(request.finalOnly);
        wanted.message.set_format(request.format);
        wanted.message.set_asked_ns(nowNs());
        wanted.message.set_moving(request.moving);
        wanted.message.set_queued(request.queued);
        if (request.page) *wanted.message.mutable_page() = *request.page;
        if (fits(wanted.message) && request.queued) {
            impl_->queuedViews_.push_back(std::move(wanted));
        } else if (fits(wanted.message)) {
            impl_->queuedViews_.clear();
            impl_->view_ = std::move(wanted);
        } else {
            impl_->viewFailed(id,
                              {ErrorCode::invalidArgument, "", "the view is larger than a server accepts"});
        }
    }
    impl_->wakeWriter();
    return id;
}

std::optional<ReceivedFrame> Connection::takeFrame() {
    std::optional<ReceivedFrame> frame;
    {
        const std::lock_guard lock(impl_->mutex_);
        if (!impl_->queuedFrames_.empty()) {
            frame = std::move(impl_->queuedFrames_.front());
            impl_->queuedFrames_.pop_front();
            if (impl_->staleFrames_ > 0) {
                --impl_->staleFrames_;
                return frame;
            }
        } else if (impl_->frame_) {
            frame = std::exchange(impl_->frame_, std::nullopt);
        } else {
            return std::nullopt;
        }
        impl_->giveBackFrame();
    }
    impl_->wakeWriter();
    return frame;
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

void Connection::thumbnail(const std::string& dataset, Reply<FramePixels> reply) {
    proto::ClientMessage question;
    question.mutable_get_thumbnail()->set_dataset(dataset);
    impl_->ask(std::move(question), proto::ServerMessage::kThumbnail,
               [reply = std::move(reply)](const Result<Impl::ServerAnswer>& answer) {
                   if (!answer.ok()) return reply(answer.error());
                   proto::Frame frame;
                   frame.set_width(answer->message.thumbnail().width());
                   frame.set_height(answer->message.thumbnail().height());
                   frame.set_encoding(proto::Frame::JPEG);
                   frame.set_format(proto::SRGB8);
                   reply(decodeFrame(frame, answer->payload));
               });
}

void Connection::listFolder(const std::string& folder, std::uint64_t first, Reply<proto::Folder> reply) {
    proto::ClientMessage question;
    question.mutable_list_folder()->set_folder(folder);
    question.mutable_list_folder()->set_first(first);
    impl_->ask(std::move(question), proto::ServerMessage::kFolder,
               typed(std::move(reply), &proto::ServerMessage::mutable_folder));
}

std::uint64_t Connection::lookAtFile(const proto::LookAtFile& wanted, Reply<proto::Look> reply) {
    proto::ClientMessage question;
    *question.mutable_look_at_file() = wanted;
    return impl_->ask(std::move(question), proto::ServerMessage::kLook,
                      typed(std::move(reply), &proto::ServerMessage::mutable_look));
}

void Connection::listLoaded(const std::string& dataset, Reply<proto::Loaded> reply) {
    proto::ClientMessage question;
    question.mutable_list_loaded()->set_dataset(dataset);
    impl_->ask(std::move(question), proto::ServerMessage::kLoaded,
               typed(std::move(reply), &proto::ServerMessage::mutable_loaded));
}

void Connection::submitJob(const proto::JobRequest& job, Reply<proto::JobStatus> reply, const JobWish& wish) {
    proto::ClientMessage question;
    auto& submitted = *question.mutable_submit_job();
    *submitted.mutable_job() = job;
    submitted.set_again(wish.again);
    submitted.set_time_limit_s(wish.timeLimit);
    impl_->ask(std::move(question), proto::ServerMessage::kJob,
               typed(std::move(reply), &proto::ServerMessage::mutable_job));
}

void Connection::cancelJob(const std::string& id, Reply<proto::JobStatus> reply) {
    proto::ClientMessage question;
    question.mutable_cancel_job()->set_id(id);
    impl_->ask(std::move(question), proto::ServerMessage::kJob,
               typed(std::move(reply), &proto::ServerMessage::mutable_job));
}

void Connection::retryJob(const std::string& id, Reply<proto::JobStatus> reply) {
    proto::ClientMessage question;
    question.mutable_retry_job()->set_id(id);
    impl_->ask(std::move(question), proto::ServerMessage::kJob,
               typed(std::move(reply), &proto::ServerMessage::mutable_job));
}

void Connection::listJobs(std::uint64_t first, Reply<proto::Jobs> reply) {
    proto::ClientMessage question;
    question.mutable_list_jobs()->set_first(first);
    impl_->ask(std::move(question), proto::ServerMessage::kJobs,
               typed(std::move(reply), &proto::ServerMessage::mutable_jobs));
}

void Connection::watchJobs(Reply<proto::Jobs> reply) {
    proto::ClientMessage question;
    question.mutable_watch_jobs();
    impl_->ask(std::move(question), proto::ServerMessage::kJobs,
               typed(std::move(reply), &proto::ServerMessage::mutable_jobs));
}

void Connection::fetchFilm(const proto::FetchFilm& piece, Reply<FilmBytes> reply) {
    proto::ClientMessage question;
    *question.mutable_fetch_film() = piece;
    impl_->ask(std::move(question), proto::ServerMessage::kFilmPiece,
               [reply = std::move(reply)](Result<Impl::ServerAnswer> answer) {
                   if (!answer.ok()) return reply(answer.error());
                   reply(FilmBytes{answer->message.film_piece(), std::move(answer->payload)});
               });
}

void Connection::ping(Reply<double> reply) {
    proto::ClientMessage question;
    question.mutable_ping();
    impl_->ask(std::move(question), proto::ServerMessage::kPong,
               [this, reply = std::move(reply)](const Result<Impl::ServerAnswer>& answer) {
                   if (!reply) return;
                   answer.ok() ? reply(statistics().roundTripMs) : reply(answer.error());
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

std::uint64_t Connection::Impl::ask(proto::ClientMessage question, Body expected, Answer answer) {
    std::uint64_t request = 0;
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
            request = ++lastRequest_;
            question.set_request(request);
            outbox_.push_back(question);
            questions_[request] = {expected, std::move(answer), std::move(question)};
        }
    }
    notify();
    wakeWriter();
    return request;
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

/// Asks everything again but for jobs that were sent, of which nobody knows whether they were submitted, and
/// queries of whose answers some are with their owner.
void Connection::Impl::askAgain(const Error& reason) {
    for (auto& [request, question] : questions_) {
        const bool submits = question.message.has_submit_job() || question.message.has_retry_job();
        question.sent = question.sent && (submits || question.begun);
    }
    failSent(reason);
    outbox_.clear();
    for (const auto& [request, question] : questions_) outbox_.push_back(question.message);
}

bool Connection::Impl::isQueued(std::uint64_t viewId) const {
    return std::any_of(queuedViews_.begin(), queuedViews_.end(),
                       [&](const auto& view) { return view.message.view_id() == viewId; });
}

void Connection::Impl::keepFrame(ReceivedFrame frame) {
    const auto viewId = frame.message.view_id();
    if (isQueued(viewId)) {
        std::erase_if(queuedViews_, [&](const auto& view) { return view.message.view_id() == viewId; });
        queuedFrames_.push_back(std::move(frame));
        return;
    }
    if (frame_) giveBackFrame();  // one frame goes unseen
    frame.payload.clear();
    frame_ = std::move(frame);
}

void Connection::Impl::viewFailed(std::uint64_t viewId, const Error& error) {
    std::erase_if(queuedViews_, [&](const auto& view) { return view.message.view_id() == viewId; });
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
