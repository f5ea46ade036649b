// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_service.h"

#include <asio/post.hpp>
#include <chrono>
#include <exception>
#include <new>
#include <optional>
#include <utility>

#include "server/log.h"

namespace mote::server {
namespace {

/// Somebody waits for it: where memory is short, it is tried again until there is some.
template <class Work>
auto surely(Work work) {
    constexpr std::chrono::milliseconds pause(10);
    for (;; std::this_thread::sleep_for(pause)) {
        try {
            return work();
        } catch (const std::bad_alloc&) {
        }
    }
}

}  // namespace

JobService::JobService(asio::io_context& home, JobSettings settings)
    : home_(home), work_(context_->get_executor()), queue_(*context_, std::move(settings)) {}

JobService::~JobService() {
    if (!thread_.joinable()) return;
    context_->stop();  // which takes no memory, as asking the thread for it would
    thread_.join();
}

Status JobService::start(JobQueue::Listener changed) {
    changed_ = std::move(changed);
    queue_.onChange([this](const proto::JobStatus& job) { tell(job); });
    MOTE_RETURN_IF_ERROR(queue_.start());
    *counts_ = queue_.counts();
    thread_ = std::thread([this] { run(); });
    return success();
}

void JobService::stop() {
    asio::post(*context_, [this] { queue_.stop(); });
}

void JobService::run() {
    for (;;) {
        try {
            context_->run();
            return;
        } catch (const std::exception& failure) {
            // Memory was short, say: what was being done is lost, the queue is not.
            log::failure("something of jobs was left undone", failure);
        }
    }
}

void JobService::ask(Question question, Answered answered) {
    struct Asked {
        Question question;
        Answered answered;
        std::optional<Result<proto::ServerMessage>> answer = {};
    };
    const auto asked = std::make_shared<Asked>(Asked{std::move(question), std::move(answered)});
    asio::post(*context_, [this, asked] {
        asked->answer.emplace(answerOf(asked->question));
        surely([&] { asio::post(home_, [asked] { asked->answered(*std::move(asked->answer)); }); });
    });
}

Result<proto::ServerMessage> JobService::answerOf(const Question& question) {
    try {
        return question(queue_);
    } catch (const std::exception& failure) {
        log::failure("a question about jobs has no answer", failure);
        return surely([] {
            return Error{ErrorCode::resourceExhausted, "", "there is not enough memory for it now"};
        });
    }
}

/// What a job is now, and not what it was at this change: an answer that was given meanwhile is no newer.
void JobService::tell(const proto::JobStatus& job) {
    auto now = queue_.find(job.id());
    asio::post(home_, [changed = changed_, now = now.ok() ? *std::move(now) : job] { changed(now); });
    tellCounts();
    // Old jobs are forgotten right after one has ended.
    asio::post(*context_, [this] { tellCounts(); });
}

void JobService::tellCounts() {
    asio::post(home_, [kept = counts_, counts = queue_.counts()]() mutable { *kept = std::move(counts); });
}

void JobService::fetchFilm(const proto::FetchFilm& request, JobQueue::FilmListener done) {
    auto answer = [&home = home_, done = std::move(done)](Result<FilmPiece> piece) {
        asio::post(home, [done, piece = std::move(piece)]() mutable { done(std::move(piece)); });
    };
    asio::post(*context_, [this, request, answer = std::move(answer)] {
        try {
            queue_.fetchFilm(request, answer);
        } catch (const std::exception& failure) {
            surely([&] { answer(Error{ErrorCode::resourceExhausted, "id", failure.what()}); });
        }
    });
}

Uploads::Remove JobService::remover() {
    return
        [context = std::weak_ptr(context_), remove = queue_.remover()](const std::filesystem::path& folder) {
            const auto alive = context.lock();
            if (alive) asio::post(*alive, [remove, folder] { remove(folder); });
        };
}

}  // namespace mote::server
