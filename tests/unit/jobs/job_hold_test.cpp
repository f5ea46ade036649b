// SPDX-License-Identifier: GPL-3.0-or-later
//
// A fault of the place makes jobs wait, not fail, and what was told is not forgotten.
#include <gmock/gmock.h>
#include <linux/capability.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// A limit of this process, as long as it lives.
class Limited {
  public:
    Limited(__rlimit_resource what, rlim_t most) : what_(what) {
        getrlimit(what_, &before_);
        const rlimit now{most, before_.rlim_max};
        setrlimit(what_, &now);
    }
    ~Limited() { setrlimit(what_, &before_); }
    Limited(const Limited&) = delete;
    Limited& operator=(const Limited&) = delete;

  private:
    const __rlimit_resource what_;
    rlimit before_{};
};

/// With so many descriptors there is none left.
rlim_t openDescriptors() {
    const int next = dup(0);
    close(next);
    return static_cast<rlim_t>(next);
}

/// As long as it lives, root is refused what others are.
class WithoutOverride {
  public:
    WithoutOverride() {
        syscall(SYS_capget, &header_, before_);
        __user_cap_data_struct now[_LINUX_CAPABILITY_U32S_3] = {before_[0], before_[1]};
        now[0].effective &= ~((1U << CAP_DAC_OVERRIDE) | (1U << CAP_DAC_READ_SEARCH));
        syscall(SYS_capset, &header_, now);
    }
    ~WithoutOverride() { syscall(SYS_capset, &header_, before_); }
    WithoutOverride(const WithoutOverride&) = delete;
    WithoutOverride& operator=(const WithoutOverride&) = delete;

  private:
    __user_cap_header_struct header_{_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct before_[_LINUX_CAPABILITY_U32S_3] = {};
};

class JobHoldTest : public JobTest {
  protected:
    JobHoldTest() { signal(SIGXFSZ, SIG_IGN); }

    std::vector<std::string> submitSome() {
        std::vector<std::string> ids;
        for (int i = 0; i < 8; ++i) ids.push_back(submit("publish:", "data/run" + std::to_string(i) + ".h5"));
        return ids;
    }
    void expectAllSucceed(const std::vector<std::string>& ids) {
        for (const auto& id : ids) EXPECT_EQ(waitForState(id, State::SUCCEEDED).error(), "");
    }
    /// Of any of them.
    void waitForWaiting(const std::string& why) {
        waitUntil(queue_->list().back().id(), [&](const auto&) {
            for (const auto& status : queue_->list()) {
                EXPECT_NE(status.state(), State::FAILED) << status.error();
                if (status.phase().find(why) != std::string::npos) return true;
            }
            return false;
        });
    }
};

TEST_F(JobHoldTest, WithoutDescriptorsJobsWait) {
    startServer();
    const auto ids = submitSome();
    {
        const Limited limited(RLIMIT_NOFILE, openDescriptors());
        waitForWaiting("waiting: ");
    }
    expectAllSucceed(ids);
}

TEST_F(JobHoldTest, WithFewDescriptorsNoJobFails) {
    startServer();
    for (rlim_t left = 0; left <= 8; ++left) {
        SCOPED_TRACE(left);
        const auto id = submit("publish:", "data/few" + std::to_string(left) + ".h5");
        {
            const Limited limited(RLIMIT_NOFILE, openDescriptors() + left);
            waitUntil(id, [](const auto& status) {
                return !status.waits_for().empty() || status.state() > State::RUNNING;
            });
        }
        expectAllSucceed({id});
    }
}

TEST_F(JobHoldTest, AnEndThatCannotBeReadIsNoInterruption) {
    startServer();
    for (rlim_t left = 0; left <= 8; ++left) {
        SCOPED_TRACE(left);
        const auto name = "go" + std::to_string(left);
        makeFifo(name);
        const auto id = submit("phase:ready wait:" + name + " publish:", "data/" + name + ".h5");
        waitForPhase(id, "ready");
        {
            const Limited limited(RLIMIT_NOFILE, openDescriptors() + left);
            release(name);
            waitUntil(id, [](const auto& status) {
                return !status.waits_for().empty() || status.state() != State::RUNNING;
            });
            EXPECT_NE(queue_->find(id).value().state(), State::QUEUED);
        }
        EXPECT_EQ(waitForState(id, State::SUCCEEDED).interrupted(), 0U);
    }
}

TEST_F(JobHoldTest, ARunningJobThatCannotBeLookedForIsNotBegunAgain) {
    startServer();
    makeFifo("go");
    const auto id = submit("pids: wait:go publish:");
    waitUntil(id, [](const auto& status) { return status.progress() > 0; });
    int begun = 0;
    for (rlim_t left = 0; left <= 16; ++left) {
        killServer();
        context_ = std::make_unique<asio::io_context>();
        queue_ = std::make_unique<JobQueue>(*context_, settings());
        const Limited limited(RLIMIT_NOFILE, openDescriptors() + left);
        if (!queue_->start().ok()) continue;  // it has not even its database
        ++begun;
        settle();
        EXPECT_EQ(queue_->find(id).value().state(), State::RUNNING) << left;
        EXPECT_EQ(queue_->find(id).value().interrupted(), 0U) << left;
    }
    EXPECT_GT(begun, 0);
    startServer();
    release("go");
    EXPECT_EQ(waitForState(id, State::SUCCEEDED).interrupted(), 0U);
}

TEST_F(JobHoldTest, AFolderThatIsDeniedKeepsNobodyElseWaiting) {
    startServer();
    const auto locked = root_ / "locked";
    std::filesystem::create_directory(locked);
    const auto first = submit("publish:", "data/locked/run.h5");
    const auto second = submit("publish:", "data/second.h5");
    std::filesystem::permissions(locked, std::filesystem::perms::none);
    {
        const WithoutOverride denied;
        expectAllSucceed({second});
        EXPECT_THAT(queue_->find(first).value().waits_for(), HasSubstr("Permission denied"));
    }
    std::filesystem::permissions(locked, std::filesystem::perms::owner_all);
    expectAllSucceed({first});
}

TEST_F(JobHoldTest, ARunThatFindsTheDiskFullIsTriedAgain) {
    auto often = settings();
    often.placePause = std::chrono::milliseconds(0);
    startServer(often);
    std::ofstream(root_ / "full") << "x";
    makeFifo("go");
    const auto id = submit("wait:go full:full publish:");
    waitForState(id, State::RUNNING);
    release("go");
    waitUntil(id, [](const auto& status) { return status.waits_for() == "no space left"; });
    waitForState(id, State::RUNNING);
    std::filesystem::remove(root_ / "full");
    release("go");
    const auto done = waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(done.interrupted(), 0U);
    EXPECT_THAT(done.log(), Contains("tried 1 of 12 times, again in 0 s"));
}

TEST_F(JobHoldTest, ADiskThatStaysFullFailsTheJobInTheEnd) {
    auto often = settings();
    often.placePause = std::chrono::milliseconds(0);
    startServer(often);
    std::ofstream(root_ / "full") << "x";
    const auto failed = waitForState(submit("full:full publish:"), State::FAILED);
    EXPECT_EQ(failed.error(), "no space left (tried 12 times)");
    EXPECT_EQ(failed.interrupted(), 0U);
}

TEST_F(JobHoldTest, WhileARootIsAwayJobsWait) {
    startServer();
    const auto away = root_.string() + ".away";
    const auto ids = submitSome();
    std::filesystem::rename(root_, away);
    waitForWaiting("a folder of data is away");
    std::filesystem::rename(away, root_);
    expectAllSucceed(ids);
}

TEST_F(JobHoldTest, WhatCannotBeStoredIsNotDone) {
    startServer();
    makeFifo("go");
    const auto running = submit("pids: wait:go publish:");
    const auto waiting = submit("publish:", "data/second.h5");
    waitForState(running, State::RUNNING);
    {
        const Limited full(RLIMIT_FSIZE, 0);
        const auto cancelled = queue_->cancel(waiting);
        ASSERT_FALSE(cancelled.ok());
        EXPECT_EQ(queue_->find(waiting).value().state(), State::QUEUED);
        EXPECT_FALSE(queue_->cancel(running).ok());
        EXPECT_FALSE(queue_->submit(request("publish:", "data/third.h5")).ok());
    }
    startServer();
    EXPECT_EQ(queue_->find(running).value().state(), State::RUNNING);
    EXPECT_EQ(queue_->find(waiting).value().state(), State::QUEUED);
    release("go");
    expectAllSucceed({running, waiting});
}

TEST_F(JobHoldTest, AnEndThatCannotBeStoredIsToldWhenItIs) {
    startServer();
    makeFifo("go");
    const auto first = submit("wait:go publish:");
    const auto second = submit("publish:", "data/second.h5");
    waitForState(first, State::RUNNING);
    const auto told = [&] {
        return std::count_if(changes_.begin(), changes_.end(),
                             [](const auto& status) { return status.state() == State::SUCCEEDED; });
    };
    {
        const Limited full(RLIMIT_FSIZE, 0);
        release("go");
        waitUntil(first, [](const auto& status) { return status.state() == State::SUCCEEDED; });
        settle();
        EXPECT_EQ(told(), 0);
        EXPECT_EQ(queue_->find(second).value().state(), State::QUEUED);
    }
    waitUntil(second, [](const auto& status) { return status.state() == State::SUCCEEDED; });
    settle();
    EXPECT_EQ(told(), 2);
}

}  // namespace
}  // namespace mote::server
