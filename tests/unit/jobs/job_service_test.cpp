// SPDX-License-Identifier: GPL-3.0-or-later
//
// The queue on a thread of its own: who asks waits for the disk, and nobody else.
#include "server/jobs/job_service.h"

#include <algorithm>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/post.hpp>
#include <chrono>
#include <future>
#include <optional>

#include "server/session/on_thread.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using Answer = Result<proto::ServerMessage>;

class JobServiceTest : public JobTest {
  protected:
    void start() {
        service_.emplace(home_, settings());
        const auto started =
            service_->start([this](const proto::JobStatus& job) { told_.push_back(job.state()); });
        ASSERT_TRUE(started.ok()) << started.error().toString();
    }
    /// Runs what comes home until it is so; half a minute at most.
    void runUntil(const std::function<bool()>& wanted) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
        while (!wanted() && std::chrono::steady_clock::now() < deadline) {
            home_.restart();
            home_.run_one_for(std::chrono::milliseconds(100));
        }
        EXPECT_TRUE(wanted());
    }
    /// As a session does.
    void ask(JobService::Question question, std::function<void(Answer)> done) {
        auto wait = [this, question = std::move(question),
                     done = std::move(done)]() mutable -> asio::awaitable<void> {
            const auto asking = [&](auto answered) {
                service_->ask(std::move(question), std::move(answered));
            };
            done(co_await onThread<Answer>(home_.get_executor(), asking));
        };
        asio::co_spawn(home_, std::move(wait), asio::detached);
    }
    Answer ask(JobService::Question question) {
        std::optional<Answer> answer;
        ask(std::move(question), [&](Answer given) { answer.emplace(std::move(given)); });
        runUntil([&] { return answer.has_value(); });
        return answer ? *answer : Answer(Error{ErrorCode::internal, "", "no answer"});
    }
    static Answer none(JobQueue&) { return proto::ServerMessage(); }

    asio::io_context home_;
    std::optional<JobService> service_;
    std::vector<int> told_;
};

TEST_F(JobServiceTest, WhoDoesNotAskDoesNotWait) {
    start();
    std::promise<void> disk;
    bool answered = false, next = false;
    ask(
        [held = disk.get_future().share()](JobQueue& queue) {
            held.wait();
            return none(queue);
        },
        [&](const Answer&) { answered = true; });
    ask(none, [&](const Answer&) { next = answered; });
    bool others = false;
    asio::post(home_, [&] { others = true; });
    home_.poll();
    EXPECT_TRUE(others);
    EXPECT_FALSE(answered);
    disk.set_value();
    runUntil([&] { return next; });
}

TEST_F(JobServiceTest, ChangesFollowTheAnswerInTheirOrder) {
    start();
    const auto status = ask([this](JobQueue& queue) -> Answer {
        MOTE_ASSIGN_OR_RETURN(auto job, queue.submit(request("publish:")));
        proto::ServerMessage message;
        *message.mutable_job() = std::move(job);
        return message;
    });
    ASSERT_TRUE(status.ok()) << status.error().toString();
    EXPECT_EQ(status->job().state(), State::QUEUED);
    EXPECT_TRUE(told_.empty());
    runUntil([&] { return !told_.empty() && told_.back() == State::SUCCEEDED; });
    EXPECT_TRUE(std::ranges::is_sorted(told_)) << "a job never becomes what it was before";
    EXPECT_EQ(told_.front(), State::QUEUED);
    runUntil([&] { return service_->counts().at("succeeded") == 1; });
    EXPECT_EQ(service_->counts().at("queued"), 0U);
}

TEST_F(JobServiceTest, ItsRemoverOutlivesIt) {
    start();
    const auto remove = service_->remover();
    const auto folder = directory_ / "state/uploads/one", kept = directory_ / "state/uploads/two";
    for (const auto& made : {folder, kept}) std::filesystem::create_directory(made);
    remove(folder);
    runUntil([&] { return !std::filesystem::exists(folder); });
    service_.reset();
    remove(kept);
    EXPECT_TRUE(std::filesystem::exists(kept));
}

TEST_F(JobServiceTest, AnEndedQueueStillAnswers) {
    start();
    service_->stop();
    const auto answer = ask([this](JobQueue& queue) -> Answer {
        const auto job = queue.submit(request("publish:"));
        return job.ok() ? Answer(proto::ServerMessage()) : Answer(job.error());
    });
    ASSERT_FALSE(answer.ok());
    EXPECT_EQ(answer.error().message, "the server takes no more jobs: it is ending");
}

}  // namespace
}  // namespace mote::server
