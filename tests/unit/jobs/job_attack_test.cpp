// SPDX-License-Identifier: GPL-3.0-or-later
//
// A hostile program in a job's place: what it tries is refused, and what it leaves behind is gone.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/landlock.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// A process of the same user that has nothing to do with the job.
class Bystander {
  public:
    Bystander() : pid_(fork()) {
        if (pid_ == 0) {
            for (;;) pause();
        }
    }
    ~Bystander() {
        kill(pid_, SIGKILL);
        waitpid(pid_, nullptr, 0);
    }
    std::string number() const { return std::to_string(pid_); }
    bool lives() const { return waitpid(pid_, nullptr, WNOHANG) == 0; }

  private:
    pid_t pid_;
};

class JobAttackTest : public JobTest {
  protected:
    void SetUp() override {
        if (syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) < 1)
            GTEST_SKIP() << "this kernel has no Landlock";
    }
    std::vector<std::string> logAfter(const std::string& script) {
        const auto done = waitForState(submit(script + " exit:1"), State::FAILED);
        return {done.log().begin(), done.log().end()};
    }
    /// Each attack was tried, and none was allowed.
    void expectRefused(const std::vector<std::string>& verbs, const std::string& word) {
        for (const auto& verb : verbs) {
            const auto log = logAfter(verb + ":" + word);  // a title is not long
            EXPECT_THAT(log, Contains(StartsWith(verb + ": ")));
            EXPECT_THAT(log, Not(Contains(EndsWith(": allowed"))));
        }
    }
};

TEST_F(JobAttackTest, otherProcessesAreOutOfReach) {
    startServer();
    const Bystander other;
    expectRefused({"kill", "ptrace", "memory", "renice", "limit"}, other.number());
    EXPECT_TRUE(other.lives());
    EXPECT_THAT(logAfter("read:/proc/" + other.number() + "/environ"), Contains("read: Permission denied"));
    EXPECT_THAT(logAfter("read:/proc/" + std::to_string(getpid()) + "/environ"),
                Contains("read: Permission denied"));
}

TEST_F(JobAttackTest, itHasNoProcessesBesidesItself) {
    startServer();
    expectRefused({"fork", "setsid", "namespace", "unshare", "bind", "memfd", "terminal"}, "");
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    expectRefused({"prctl"}, "");  // which they call themselves
#endif
}

TEST_F(JobAttackTest, filesThatItReadsStayAsTheyAre) {
    startServer();
    const auto file = root_ / "run.other";
    std::ofstream(file) << "content";
    const auto before = std::filesystem::last_write_time(file);
    expectRefused({"chmod", "fchmod", "times", "cut", "remove", "link"}, file.string());
    EXPECT_EQ(std::filesystem::file_size(file), 7U);
    EXPECT_EQ(std::filesystem::last_write_time(file), before);
    EXPECT_NE(std::filesystem::status(file).permissions(), std::filesystem::perms::none);
}

TEST_F(JobAttackTest, itTakesNoMoreMemoryThanItWasGiven) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer takes more memory than this test allows";
#endif
    auto limited = settings();
    limited.memory = std::uint64_t{1} << 30;
    startServer(limited);
    expectRefused({"take", "share"}, "4096");
    EXPECT_THAT(logAfter("take:64"), Contains("take: allowed"));
}

TEST_F(JobAttackTest, itKnowsNothingOfTheServersEnvironment) {
    setenv("MOTE_TEST_SECRET", "x", 1);
    startServer();
    const auto log = logAfter("environment:");
    unsetenv("MOTE_TEST_SECRET");
    EXPECT_THAT(log, Contains("variable PATH"));
    EXPECT_THAT(log, Not(Contains(HasSubstr("SECRET"))));
}

TEST_F(JobAttackTest, onlyPlainOutputsAreGivenTheirPlace) {
    startServer();
    for (const std::string kind : {"link", "pipe", "setuid", "second", "inside"}) {
        const auto failed = waitForState(submit("wrong:" + kind), State::FAILED);
        EXPECT_THAT(failed.error(), HasSubstr("neither a file nor a folder of the job's own")) << kind;
        EXPECT_TRUE(std::filesystem::is_empty(root_)) << kind;
    }
}

TEST_F(JobAttackTest, whatIsThereIsNeverReplaced) {
    startServer();
    makeFifo("go");
    const auto id = submit("phase:on publish: wait:go");
    waitForPhase(id, "on");
    std::ofstream(root_ / "run.h5") << "another's";
    release("go");
    EXPECT_THAT(waitForState(id, State::FAILED).error(), HasSubstr("exists already"));
    EXPECT_TRUE(std::filesystem::is_regular_file(root_ / "run.h5"));
    EXPECT_FALSE(std::filesystem::exists(root_ / ("run.h5.partial-" + id)));
}

}  // namespace
}  // namespace mote::server
