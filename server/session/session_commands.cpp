// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a session's client asks for: views, whom it follows, datasets, jobs, numbers.
#include <fmt/format.h>

#include <asio/post.hpp>

#include "server/session/on_thread.h"
#include "server/session/session.h"

namespace mote::server {
namespace {

proto::ServerMessage failure(const Error& error) {
    return failureMessage(0, error, false);
}

proto::ServerMessage listLoaded(DatasetService& datasets, const std::string& dataset) {
    auto loaded = datasets.loaded(dataset);
    if (!loaded.ok()) return failure(loaded.error());
    proto::ServerMessage message;
    *message.mutable_loaded() = *std::move(loaded);
    return message;
}

// A client's commands about jobs as questions to the jobs' thread.

using Answer = Result<proto::ServerMessage>;
using Question = JobService::Question;

Answer told(Result<proto::JobStatus> job) {
    if (!job.ok()) return job.error();
    proto::ServerMessage message;
    *message.mutable_job() = *std::move(job);
    return message;
}

Question submitJob(proto::SubmitJob& message, SessionId client, const std::shared_ptr<Uploads>& uploads) {
    const auto job = std::make_shared<proto::JobRequest>(std::move(*message.mutable_job()));
    const JobWish wish{message.again(), message.time_limit_s(), std::to_string(client)};
    return [job, wish, uploads](JobQueue& jobs) -> Answer {
        const auto resolved = uploads->resolve(*job);
        if (!resolved.ok()) return resolved.error().within("job");
        auto status = jobs.submit(*resolved, wish);
        if (!status.ok()) return status.error().within("job");
        return told(std::move(status));
    };
}

Question retryJob(const std::string& id, SessionId client) {
    return [id, client = std::to_string(client)](JobQueue& jobs) { return told(jobs.retry(id, client)); };
}

Question cancelJob(const std::string& id) {
    return [id](JobQueue& jobs) -> Answer {
        MOTE_RETURN_IF_ERROR(jobs.cancel(id));
        return told(jobs.find(id));
    };
}

Question pageOfJobs(const proto::ListJobs& wanted) {
    return [wanted](const JobQueue& jobs) -> Answer {
        proto::ServerMessage message;
        *message.mutable_jobs() = jobs.page(wanted.first(), wanted.count());
        return message;
    };
}

Question addUpload(proto::Upload& message, const std::shared_ptr<Uploads>& uploads) {
    const auto part = std::make_shared<proto::Upload>(std::move(message));
    return [part, uploads](JobQueue&) -> Answer {
        MOTE_ASSIGN_OR_RETURN(const auto size, uploads->add(*part));
        proto::ServerMessage uploaded;
        uploaded.mutable_uploaded()->set_name(part->name());
        uploaded.mutable_uploaded()->set_size(size);
        return uploaded;
    };
}

/// Null: the command is not about jobs. Takes what is large out of the command. `client`: whose jobs take
/// turns with others'; `uploads`: that client's.
Question jobQuestion(proto::ClientMessage& command, SessionId client,
                     const std::shared_ptr<Uploads>& uploads) {
    using Body = proto::ClientMessage;
    switch (command.body_case()) {
        case Body::kSubmitJob:
            return submitJob(*command.mutable_submit_job(), client, uploads);
        case Body::kRetryJob:
            return retryJob(command.retry_job().id(), client);
        case Body::kListJobs:
            return pageOfJobs(command.list_jobs());
        case Body::kUpload:
            return addUpload(*command.mutable_upload(), uploads);
        case Body::kCancelJob:
            return cancelJob(command.cancel_job().id());
        case Body::kWatchJobs:
            return allJobs;
        default:
            return nullptr;
    }
}

}  // namespace

Result<proto::ServerMessage> allJobs(JobQueue& queue) {
    proto::ServerMessage message;
    auto& jobs = *message.mutable_jobs();
    for (auto& job : queue.list()) *jobs.add_jobs() = std::move(job);
    jobs.set_total(queue.size());
    return message;
}

// ---------------------------------------------------------------------------------------------- views

asio::awaitable<void> Session::setView(std::uint64_t request, const proto::SetView& message) {
    auto task = makeTask(request, message);
    if (!task.ok()) co_return refuse(request, task.error());
    if (!message.queued()) context_.parked->setView(id_, message);
    const auto found = co_await findDatasets((*task)->view);
    if (closed_) co_return;
    if (!found.ok()) co_return refuse(request, found.error());
    if (!message.queued()) {
        context_.following->unfollow(id_);
        context_.following->viewChanged(id_, message);
    }
    const auto drawn = frames_->draw(*std::move(task));
    if (!drawn.ok()) refuse(request, drawn.error());
}

/// A dataset that was published a moment ago may not be known yet: only then is the disk asked first.
asio::awaitable<Status> Session::findDatasets(const View& view) {
    bool known = true;
    for (const auto& layer : view.layers) {
        known = known && context_.datasets->contains(layer.dataset);
        const auto* const stipple = layer.stipple();
        if (stipple != nullptr && !stipple->image().empty())
            known = known && context_.datasets->contains(stipple->image());
    }
    if (known) co_return success();
    co_return co_await rescan();
}

void Session::listSessions(std::uint64_t request) {
    proto::ServerMessage message;
    *message.mutable_sessions() = context_.following->list(id_);
    reply(request, std::move(message));
}

void Session::follow(std::uint64_t request, SessionId whom) {
    const auto before = std::exchange(followRequest_, request);
    const auto show = [weak = weak_from_this()](const proto::Followed& followed) {
        if (const auto self = weak.lock()) self->show(followed);
    };
    followReply_ = request;
    const auto follows = context_.following->follow(id_, whom, show);
    if (follows.ok()) return;
    followRequest_ = before;
    followReply_ = 0;
    refuse(request, follows.error());
}

/// Who hears of it, and the pictures, which come after, of a view that the other session has found its data
/// for.
void Session::show(const proto::Followed& followed) {
    if (closed_ || leaving_) return;
    followed_ = followed;
    outbox_.followedChanged();
    writerWake_.notify();
    if (!followed.has_view()) return;
    auto task = makeTask(followRequest_, followed.view());
    const auto drawn = task.ok() ? frames_->draw(*std::move(task)) : Status(task.error());
    if (!drawn.ok()) refuse(followRequest_, drawn.error());
}

// ------------------------------------------------------------------------------------------- commands

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
    if (command.has_watch_jobs()) {
        watchesJobs_ = true;
        context_.parked->watchJobs(id_);
    }
    if (auto question = jobQuestion(command, id_, uploads_)) {
        while (!outbox_.room() && !closed_) co_await readerWake_.wait();
        co_return co_await askJobs(command.request(), std::move(question));
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
        case Body::kListFolder:
            co_return co_await listFolder(command.list_folder());
        case Body::kListLoaded:
            co_return listLoaded(*context_.datasets, command.list_loaded().dataset());
        case Body::kFetchFilm:
            co_return co_await fetchArtifact(command.fetch_film());
        default:
            co_return failure(unsupported("message", "it is not known here"));
    }
}

/// Until the disk was looked at.
asio::awaitable<Status> Session::rescan() {
    return onThread<Status>(
        executor_, [datasets = context_.datasets](auto answered) { datasets->rescan(std::move(answered)); });
}

/// What is on the disk now, not what was at the last look.
asio::awaitable<proto::ServerMessage> Session::listDatasets() {
    const auto looked = co_await rescan();
    if (!looked.ok()) co_return failure(looked.error());
    proto::ServerMessage message;
    *message.mutable_catalogue() = *context_.datasets->catalogue();
    co_return message;
}

asio::awaitable<proto::ServerMessage> Session::describe(const std::string& dataset) {
    const auto ask = [&](auto answered) { context_.datasets->describe(dataset, std::move(answered)); };
    auto described = co_await onThread<Result<proto::Description>>(executor_, ask);
    if (!described.ok()) co_return failure(described.error());
    proto::ServerMessage message;
    *message.mutable_description() = *std::move(described);
    co_return message;
}

asio::awaitable<proto::ServerMessage> Session::listFolder(const proto::ListFolder& wanted) {
    const auto ask = [&](auto answered) { context_.jobs->listFolder(wanted, std::move(answered)); };
    auto folder = co_await onThread<Result<proto::Folder>>(executor_, ask);
    if (!folder.ok()) co_return failure(folder.error());
    proto::ServerMessage message;
    *message.mutable_folder() = *std::move(folder);
    co_return message;
}

asio::awaitable<void> Session::askJobs(std::uint64_t request, JobService::Question question) {
    const auto ask = [&](auto answered) { context_.jobs->ask(std::move(question), std::move(answered)); };
    auto answer = co_await onThread<Result<proto::ServerMessage>>(executor_, ask);
    if (closed_ || leaving_) co_return;
    if (!answer.ok()) co_return reply(request, failure(answer.error()));
    outbox_.jobsTold(*answer);  // what is told of them next is newer
    reply(request, *std::move(answer));
}

asio::awaitable<Reply> Session::fetchArtifact(const proto::FetchFilm& request) {
    const auto ask = [&](auto answered) { context_.jobs->fetchArtifact(request, std::move(answered)); };
    auto piece = co_await onThread<Result<ArtifactPiece>>(executor_, ask);
    if (!piece.ok()) co_return failure(piece.error());
    proto::ServerMessage message;
    *message.mutable_film_piece() = std::move(piece->message);
    co_return Reply(std::move(message), std::move(piece->bytes));
}

// -------------------------------------------------------------------------------------- looks at files

/// One at a time: a client that asks for another one does not wait for this one any more.
void Session::lookAtFile(std::uint64_t request, const proto::LookAtFile& wanted) {
    if (fileLook_) cancelLook(fileLook_->request);
    const auto answered = [weak = weak_from_this(), executor = executor_,
                           request](Result<proto::Look> answer) {
        asio::post(executor, [weak, request, answer = std::move(answer)]() mutable {
            const auto self = weak.lock();
            if (!self || !self->fileLook_ || self->fileLook_->request != request) return;
            self->fileLook_.reset();
            if (!answer.ok()) return self->refuse(request, answer.error());
            proto::ServerMessage message;
            *message.mutable_look() = *std::move(answer);
            self->reply(request, std::move(message));
        });
    };
    fileLook_ = FileLook{request, context_.jobs->look(wanted, answered)};
}

void Session::endLook() {
    if (fileLook_) context_.jobs->cancelLook(fileLook_->ticket);
    fileLook_.reset();
}

void Session::cancelLook(std::uint64_t request) {
    if (!fileLook_ || fileLook_->request != request) return;
    endLook();
    refuse(request, wasCancelled("it is not looked at any more"));
}

// -------------------------------------------------------------------------------------------- numbers

/// A dataset that was published a moment ago may not be known yet: only then is the disk asked first.
asio::awaitable<void> Session::query(proto::ClientMessage message) {
    auto& query = *message.mutable_query();
    auto found = success();
    if (!query.dataset().empty() && !context_.datasets->contains(query.dataset())) found = co_await rescan();
    if (closed_) co_return;
    if (!found.ok()) co_return refuse(message.request(), found.error());
    const auto ready = [weak = weak_from_this()] {
        if (const auto self = weak.lock()) self->answersWake_.notify();
    };
    const auto taken = queries_.ask(message.request(), std::move(query), ready);
    if (!taken.ok()) refuse(message.request(), taken.error());
}

asio::awaitable<void> Session::thumbnail(std::uint64_t request, const std::string& dataset) {
    auto found = success();
    if (!context_.datasets->contains(dataset)) found = co_await rescan();
    if (closed_) co_return;
    if (!found.ok()) co_return refuse(request, found.error());
    const auto ready = [weak = weak_from_this()] {
        if (const auto self = weak.lock()) self->answersWake_.notify();
    };
    const auto taken = thumbnails_.ask(request, dataset, ready);
    if (!taken.ok()) co_return refuse(request, taken.error());
    if (!*taken) co_return;
    refuse(**taken, {ErrorCode::resourceExhausted, "dataset",
                     fmt::format("{} thumbnails were asked for after this one, and no more of a client wait",
                                 SessionThumbnails::mostAsked)});
}

/// False if there is none.
bool Session::handOnThumbnail() {
    auto answered = thumbnails_.take();
    if (!answered) return false;
    if (!answered->answer.ok()) {
        refuse(answered->request, answered->answer.error());
        return true;
    }
    proto::ServerMessage text;
    auto& thumbnail = *text.mutable_thumbnail();
    thumbnail.set_dataset(answered->dataset);
    thumbnail.set_width(Thumbnail::width);
    thumbnail.set_height(Thumbnail::height);
    reply(answered->request, Reply(std::move(text), (*answered->answer)->jpeg));
    return true;
}

asio::awaitable<void> Session::handOnAnswers() {
    while (!closed_ && !leaving_) {
        // The writer wakes readers and workers alike when there is room again.
        while (!outbox_.room() && !closed_) co_await readerWake_.wait();
        if (closed_) co_return;
        if (handOnThumbnail()) continue;
        auto answered = queries_.take();
        if (!answered) {
            co_await answersWake_.wait();
            continue;
        }
        if (!answered->answer.ok()) {
            refuse(answered->request, answered->answer.error());
            continue;
        }
        proto::ServerMessage text;
        *text.mutable_answer() = std::move(answered->answer->message);
        reply(answered->request, Reply(std::move(text), std::move(answered->answer->payload)));
    }
}

}  // namespace mote::server
