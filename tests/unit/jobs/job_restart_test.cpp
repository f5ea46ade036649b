// SPDX-License-Identifier: GPL-3.0-or-later
//
// A server that is killed and started again knows its jobs.
#include <gmock/gmock.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "server/jobs/job_store.h"
#include "server/jobs/process_identity.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

class JobRestartTest : public JobTest {
  protected:
    struct Processes {
        int prep = 0;
        int supervisor = 0;
    };

    Processes processesOf(const std::string& id, int after = 0) {
        Processes found;
        waitUntil(id, [&](const auto& status) {
            std::istringstream words(status.phase());
            return words >> found.prep >> found.supervisor && found.prep != after;
        });
        return found;
    }
};

TEST_F(JobRestartTest, aRunningJobGoesOn) {
    startServer();
    makeFifo("go");
    const auto id = submit("pids: wait:go half:after publish:");
    const auto before = processesOf(id);
    startServer();
    EXPECT_EQ(queue_->find(id).value().state(), State::RUNNING);
    EXPECT_EQ(processesOf(id).prep, before.prep) << "it was started a second time";
    release("go");
    EXPECT_EQ(waitForState(id, State::SUCCEEDED).progress(), 1);
}

TEST_F(JobRestartTest, aJobThatEndsBetweenTwoServersIsKnown) {
    startServer();
    makeFifo("go");
    const auto good = submit("pids: wait:go publish:");
    const auto processes = processesOf(good);
    killServer();
    release("go");
    waitForEnd(processes.supervisor);
    startServer();
    EXPECT_EQ(queue_->find(good).value().state(), State::SUCCEEDED);
}

TEST_F(JobRestartTest, aFailureBetweenTwoServersIsKnown) {
    startServer();
    makeFifo("go");
    const auto bad = submit("pids: wait:go print:no_space_left exit:1");
    const auto processes = processesOf(bad);
    killServer();
    release("go");
    waitForEnd(processes.supervisor);
    startServer();
    EXPECT_EQ(queue_->find(bad).value().state(), State::FAILED);
    EXPECT_EQ(queue_->find(bad).value().error(), "no_space_left");
}

TEST_F(JobRestartTest, waitingJobsAreKept) {
    startServer();
    makeFifo("go");
    const auto first = submit("pids: wait:go publish:");
    const auto second = submit("publish:", "data/second.h5");
    processesOf(first);
    startServer();
    ASSERT_THAT(queue_->list(), SizeIs(2));
    release("go");
    waitForState(first, State::SUCCEEDED);
    waitForState(second, State::SUCCEEDED);
}

TEST_F(JobRestartTest, anInterruptedJobIsQueuedAgainOnce) {
    startServer();
    makeFifo("never");
    const auto id = submit("pids: draft: wait:never");
    auto processes = processesOf(id);
    killServer();
    kill(processes.supervisor, SIGKILL);
    waitForEnd(processes.supervisor);
    waitForEnd(processes.prep);  // it does not outlive its supervisor

    startServer();
    EXPECT_EQ(queue_->find(id).value().state(), State::QUEUED);
    EXPECT_FALSE(std::filesystem::exists(root_ / ("run.h5.partial-" + id)));
    EXPECT_EQ(queue_->find(id).value().interrupted(), 1U);
    processes = processesOf(id, processes.prep);
    kill(processes.supervisor, SIGKILL);
    const auto failed = waitForState(id, State::FAILED);
    EXPECT_THAT(failed.error(), HasSubstr("interrupted twice"));
    waitForEnd(processes.prep);
    std::filesystem::remove(root_ / "never");
    EXPECT_TRUE(comes([&] { return std::filesystem::is_empty(root_); })) << "a draft is still there";
}

TEST_F(JobRestartTest, DraftsOfOthersStay) {
    const std::vector<std::filesystem::path> others{root_ / "run.h5.partial-1234",
                                                    root_ / "run.h5.partial-ffffffffffffffff",
                                                    root_ / "run.h5.partial-ffffffffffffffff.gone-1"};
    for (const auto& other : others) std::filesystem::create_directories(other / "run.h5");
    const auto othersAlone = [&] {
        return std::distance(std::filesystem::directory_iterator(root_), {}) ==
               static_cast<std::ptrdiff_t>(others.size());
    };
    startServer();
    const auto id = submit("draft: die:9");
    waitForState(id, State::FAILED);
    EXPECT_TRUE(comes(othersAlone)) << "its own is still there";
    // What a server that was killed did not come to remove, the next one does.
    killServer();
    for (const char* left : {"", ".gone-0123456789abcdef"})
        std::filesystem::create_directories(root_ / ("run.h5.partial-" + id + left) / "run.h5");
    startServer();
    EXPECT_TRUE(comes(othersAlone));
    for (const auto& other : others) EXPECT_TRUE(std::filesystem::exists(other / "run.h5")) << other;
}

TEST_F(JobRestartTest, WhatALiveJobMakesIsNotSwept) {
    startServer();
    makeFifo("go");
    const auto id = submit("pids: draft: wait:go publish:");
    processesOf(id);
    const auto draft = root_ / ("run.h5.partial-" + id);
    std::filesystem::create_directory(draft.string() + ".gone-1");
    startServer();
    EXPECT_TRUE(comes([&] { return !std::filesystem::exists(draft.string() + ".gone-1"); }));
    EXPECT_TRUE(std::filesystem::exists(draft));
    release("go");
    EXPECT_EQ(waitForState(id, State::SUCCEEDED).error(), "");
}

TEST_F(JobRestartTest, aCancelIsRemembered) {
    startServer();
    makeFifo("never");
    const auto id = submit("ignore: pids: wait:never");
    const auto processes = processesOf(id);
    ASSERT_TRUE(queue_->cancel(id).ok());
    startServer();  // 5 s before it is killed
    EXPECT_EQ(waitForState(id, State::CANCELLED).error(), "");
    waitForEnd(processes.prep);
}

TEST_F(JobRestartTest, aPublishedOutputProvesSuccess) {
    startServer();
    makeFifo("never");
    const auto id = submit("pids: wait:never");
    const auto processes = processesOf(id);
    std::ofstream(root_ / "run.h5") << "x";  // as its supervisor does, which then is killed
    kill(processes.supervisor, SIGKILL);
    EXPECT_EQ(waitForState(id, State::SUCCEEDED).error(), "");
    waitForEnd(processes.prep);
}

TEST_F(JobRestartTest, aReusedProcessIdIsNotTheJob) {
    // This process has the number that the job had, but it began at another time.
    auto identity = ProcessIdentity::of(getpid());
    ASSERT_TRUE(identity);
    EXPECT_TRUE(identity->open().ok());
    auto stranger = *identity;
    ++stranger.startTime;
    EXPECT_EQ(stranger.open().error().code, ErrorCode::notFound);
    auto rebooted = *identity;
    rebooted.boot = "another";
    EXPECT_EQ(rebooted.open().error().code, ErrorCode::notFound);
    EXPECT_EQ(ProcessIdentity::parse(identity->toString()), *identity);
    for (const char* text : {"", "x", "12", "12 34", "-1 2 boot", "1 2 boot", "0 2 boot"}) {
        EXPECT_FALSE(ProcessIdentity::parse(text)) << text;
    }

    std::filesystem::create_directory(directory_ / "state");
    JobRecord record;
    record.status.set_id("00000000deadbeef");
    record.status.set_state(State::RUNNING);
    *record.status.mutable_request() = request("publish:");
    record.attempts = 1;
    record.handle = "local " + stranger.toString();
    {
        auto store = JobStore::open(directory_ / "state/jobs.sqlite");
        ASSERT_TRUE(store.ok());
        ASSERT_TRUE(store->insert(record).ok());
    }
    startServer();
    EXPECT_EQ(queue_->find("00000000deadbeef").value().state(), State::QUEUED);
    waitForState("00000000deadbeef", State::SUCCEEDED);
}

TEST_F(JobRestartTest, twoServersCannotShareAStateDirectory) {
    startServer();
    asio::io_context context;
    JobQueue second(context, settings());
    const auto started = second.start();
    ASSERT_FALSE(started.ok());
    EXPECT_EQ(started.error().code, ErrorCode::alreadyExists);
}

TEST_F(JobRestartTest, aBrokenDatabaseIsMovedAsideAndItsJobsAreKept) {
    startServer();
    const auto id = submit("publish:");
    waitForState(id, State::SUCCEEDED);
    killServer();
    const auto database = directory_ / "state/jobs.sqlite";
    // Each of these has been seen: other bytes, a cut file, a flipped page, a database of someone else.
    const auto overwrite = [](const std::filesystem::path& file) {
        std::ofstream(file) << "this is no database at all, however long it may be, and it is";
    };
    const std::vector<std::function<void(const std::filesystem::path&)>> damages{
        overwrite,
        [](const auto& file) {
            std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2 + 7);
        },
        [](const auto& file) { std::filesystem::resize_file(file, 50); },
    };
    int n = 0;
    for (const auto& damage : damages) {
        for (const auto& file : {database, JobStore::copyOf(database)}) {
            damage(file);
            startServer();
            EXPECT_EQ(queue_->find(id).value().state(), State::SUCCEEDED) << n;
            EXPECT_TRUE(std::filesystem::exists(file.string() + ".broken-" + std::to_string(n + 1)));
            killServer();
        }
        ++n;
    }
    std::filesystem::remove(database);
    startServer();
    EXPECT_EQ(queue_->find(id).value().state(), State::SUCCEEDED);
    killServer();
    overwrite(database);
    overwrite(JobStore::copyOf(database));
    startServer();
    EXPECT_TRUE(queue_->list().empty()) << "nobody knows them any more";
    waitForState(submit("publish:", "data/again.h5"), State::SUCCEEDED);
}

TEST_F(JobRestartTest, anUnwritableStateDirectoryIsAnError) {
    auto broken = settings();
    std::ofstream(directory_ / "file") << "x";
    broken.stateDirectory = directory_ / "file/state";
    asio::io_context context;
    JobQueue queue(context, broken);
    const auto started = queue.start();
    ASSERT_FALSE(started.ok());
    EXPECT_THAT(started.error().toString(), HasSubstr("file/state"));
}

}  // namespace
}  // namespace mote::server
