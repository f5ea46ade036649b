// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_queue.h"

#include <gmock/gmock.h>

#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

using JobQueueTest = JobTest;

std::vector<std::string> logOf(const proto::JobStatus& status) {
    return {status.log().begin(), status.log().end()};
}

TEST_F(JobQueueTest, aJobRunsAndSucceeds) {
    startServer();
    makeFifo("go");
    const auto id = submit("print:hello half:working wait:go publish:");
    EXPECT_EQ(queue_->find(id).value().state(), State::QUEUED);

    const auto working = waitForPhase(id, "working");
    EXPECT_EQ(working.state(), State::RUNNING);
    EXPECT_DOUBLE_EQ(working.progress(), 0.5);
    EXPECT_THAT(logOf(working), Contains("hello"));
    EXPECT_GE(working.started_ms(), working.created_ms());

    release("go");
    const auto done = waitForState(id, State::SUCCEEDED);
    EXPECT_DOUBLE_EQ(done.progress(), 1);
    EXPECT_EQ(done.error(), "");
    EXPECT_GE(done.finished_ms(), done.started_ms());
    EXPECT_TRUE(std::filesystem::exists(root_ / "run.h5"));
    EXPECT_TRUE(std::filesystem::is_empty(directory_ / "state/jobs"));

    settle();
    std::vector<int> states;
    for (const auto& change : changes_) {
        if (states.empty() || states.back() != change.state()) states.push_back(change.state());
    }
    EXPECT_THAT(states, ElementsAre(State::QUEUED, State::RUNNING, State::SUCCEEDED));
}

TEST_F(JobQueueTest, aFailureSaysWhatTheJobSaidLast) {
    startServer();
    const auto id = submit("print:first print:run.h5:_is_truncated exit:3");
    const auto failed = waitForState(id, State::FAILED);
    EXPECT_EQ(failed.error(), "run.h5:_is_truncated");
    EXPECT_THAT(logOf(failed), Contains("first"));
}

TEST_F(JobQueueTest, aSilentFailureSaysItsCode) {
    startServer();
    const auto failed = waitForState(submit("exit:7"), State::FAILED);
    EXPECT_THAT(failed.error(), HasSubstr("7"));
}

TEST_F(JobQueueTest, aCrashNamesItsSignal) {
    startServer();
    const auto failed = waitForState(submit("draft: die:10"), State::FAILED);
    EXPECT_THAT(failed.error(), HasSubstr("signal 10"));
    EXPECT_TRUE(std::filesystem::is_empty(root_)) << "the draft is still there";
}

TEST_F(JobQueueTest, successWithoutAnOutputIsAFailure) {
    startServer();
    EXPECT_THAT(waitForState(submit("phase:x"), State::FAILED).error(), HasSubstr("output is not there"));
}

TEST_F(JobQueueTest, aProgramThatCannotBeStartedIsAFailure) {
    auto broken = settings();
    broken.prep = directory_ / "nothing";
    startServer(broken);
    EXPECT_THAT(waitForState(submit("publish:"), State::FAILED).error(), HasSubstr("cannot be started"));
}

TEST_F(JobQueueTest, aSupervisorThatCannotBeStartedIsAFailure) {
    auto broken = settings();
    broken.supervisor = directory_ / "nothing";
    startServer(broken);
    EXPECT_THAT(waitForState(submit("publish:"), State::FAILED).error(), HasSubstr("cannot be started"));
}

TEST_F(JobQueueTest, whatAJobPrintsBecomesPlainText) {
    startServer();
    const auto failed = waitForState(submit("noise: exit:1"), State::FAILED);
    EXPECT_EQ(failed.error(), "a???? b\xc3\xa9");
}

TEST_F(JobQueueTest, aWaitingJobIsCancelledAtOnce) {
    startServer();
    makeFifo("go");
    const auto running = submit("phase:on wait:go publish:");
    const auto waiting = submit("publish:", "data/other.h5");
    waitForPhase(running, "on");
    ASSERT_TRUE(queue_->cancel(waiting).ok());
    EXPECT_EQ(queue_->find(waiting).value().state(), State::CANCELLED);
    release("go");
    waitForState(running, State::SUCCEEDED);
    settle();
    EXPECT_FALSE(std::filesystem::exists(root_ / "other.h5"));
}

TEST_F(JobQueueTest, aRunningJobIsCancelledWithoutDebris) {
    startServer();
    makeFifo("never");
    const auto id = submit("draft: phase:on wait:never publish:");
    waitForPhase(id, "on");
    ASSERT_TRUE(queue_->cancel(id).ok());
    ASSERT_TRUE(queue_->cancel(id).ok());  // twice is harmless
    const auto cancelled = waitForState(id, State::CANCELLED);
    EXPECT_EQ(cancelled.error(), "");
    std::filesystem::remove(root_ / "never");
    EXPECT_TRUE(std::filesystem::is_empty(root_)) << "the draft is still there";
    EXPECT_TRUE(queue_->cancel(id).ok());  // finished: nothing to do
}

TEST_F(JobQueueTest, aJobThatIgnoresSigtermIsKilled) {
    startServer();
    makeFifo("never");
    const auto id = submit("ignore: draft: pids: wait:never");
    const auto started = waitUntil(id, [](const auto& status) { return status.progress() > 0; });
    const int pid = std::stoi(started.phase());
    ASSERT_TRUE(queue_->cancel(id).ok());
    waitForState(id, State::CANCELLED);
    waitForEnd(pid);
}

TEST_F(JobQueueTest, cancellingAnUnknownJobIsNotFound) {
    startServer();
    const auto cancelled = queue_->cancel("0123456789abcdef");
    ASSERT_FALSE(cancelled.ok());
    EXPECT_EQ(cancelled.error().code, ErrorCode::notFound);
}

TEST_F(JobQueueTest, noClientFillsTheQueueAlone) {
    auto few = settings();
    few.queued = 4;
    startServer(few);
    makeFifo("go");
    waitForPhase(submit("phase:on wait:go publish:"), "on");
    const auto submitAs = [&](const char* client, const std::string& output) {
        return queue_->submit(request("publish:", output), {false, 0, client});
    };
    EXPECT_TRUE(submitAs("one", "data/a.h5").ok());
    EXPECT_TRUE(submitAs("one", "data/b.h5").ok());
    const auto refused = submitAs("one", "data/c.h5");
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(refused.error().message, HasSubstr("of this client"));
    EXPECT_TRUE(submitAs("two", "data/c.h5").ok());
    EXPECT_TRUE(submitAs("two", "data/d.h5").ok());
    EXPECT_FALSE(submitAs("three", "data/e.h5").ok()) << "the queue is full";
    release("go");
    for (const auto& status : queue_->list()) waitForState(status.id(), State::SUCCEEDED);
}

TEST_F(JobQueueTest, onlySoManyRunAndWait) {
    auto few = settings();
    few.running = 2;
    few.queued = 2;
    startServer(few);
    makeFifo("go");
    std::vector<std::string> ids;
    for (const char* output : {"data/a.h5", "data/b.h5"})
        ids.push_back(submit("phase:on wait:go publish:", output));
    for (const auto& id : ids) waitForPhase(id, "on");
    for (const char* output : {"data/c.h5", "data/d.h5"}) ids.push_back(submit("publish:", output));
    settle();
    EXPECT_EQ(queue_->find(ids[2]).value().state(), State::QUEUED);
    const auto refused = queue_->submit(request("publish:", "data/e.h5"));
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::resourceExhausted);

    release("go");
    release("go");
    for (const auto& id : ids) waitForState(id, State::SUCCEEDED);
    std::vector<std::string> listed;
    for (const auto& status : queue_->list()) listed.push_back(status.id());
    EXPECT_THAT(listed, ElementsAre(ids[3], ids[2], ids[1], ids[0]));
}

TEST_F(JobQueueTest, twoJobsCannotMakeTheSameOutput) {
    startServer();
    makeFifo("go");
    const auto id = submit("phase:on wait:go publish:");
    auto second = queue_->submit(request("publish:"));
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, ErrorCode::alreadyExists);
    EXPECT_THAT(second.error().message, HasSubstr(id));
    release("go");
    waitForState(id, State::SUCCEEDED);
    second = queue_->submit(request("phase:another publish:"));
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, ErrorCode::alreadyExists);
    EXPECT_EQ(second.error().where, "output");
}

TEST_F(JobQueueTest, finishedJobsAreForgottenInTheEnd) {
    auto few = settings();
    few.kept = 2;
    startServer(few);
    std::vector<std::string> ids;
    for (const char* output : {"data/a.h5", "data/b.h5", "data/c.h5"}) {
        ids.push_back(submit("publish:", output));
        waitForState(ids.back(), State::SUCCEEDED);
    }
    settle();
    EXPECT_THAT(queue_->list(), SizeIs(2));
    EXPECT_FALSE(queue_->find(ids[0]).ok());
    startServer(few);
    EXPECT_THAT(queue_->list(), SizeIs(2));
}

TEST_F(JobQueueTest, aStoppedQueueTakesNothingAndCallsNobody) {
    startServer();
    submit("publish:");
    const auto before = changes_.size();
    queue_->stop();
    settle();
    EXPECT_EQ(changes_.size(), before);
    EXPECT_FALSE(queue_->submit(request("publish:", "data/other.h5")).ok());
    for (const auto& [state, count] : queue_->counts()) EXPECT_EQ(count, 0U) << state;
}

TEST_F(JobQueueTest, rootsThatAreNoneAreRefused) {
    for (const char* root : {"data", "=/tmp", "data=", "a/b=/tmp", "data=/does/not/exist", "..=/tmp"}) {
        auto broken = settings();
        broken.roots = {root};
        asio::io_context context;
        JobQueue queue(context, broken);
        EXPECT_FALSE(queue.start().ok()) << root;
    }
}

}  // namespace
}  // namespace mote::server
