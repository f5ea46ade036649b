// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a job may not do, although the server's user may.
#include <gmock/gmock.h>
#include <linux/landlock.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <fstream>

#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class JobRightsTest : public JobTest {
  protected:
    std::vector<std::string> logAfter(const std::string& script) {
        const auto done = waitForState(submit(script + " exit:1"), State::FAILED);
        return {done.log().begin(), done.log().end()};
    }
};

bool landlockThere() {
    return syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) >= 1;
}

TEST_F(JobRightsTest, filesOutsideItsRootsAreOutOfReach) {
    if (!landlockThere()) GTEST_SKIP() << "this kernel has no Landlock";
    startServer();
    const auto secret = directory_ / "secret";
    std::ofstream(secret) << "x";
    EXPECT_THAT(logAfter("read:" + secret.string()), Contains("read: Permission denied"));
    EXPECT_THAT(logAfter("touch:" + (directory_ / "state/jobs.sqlite").string()),
                Contains("touch: Permission denied"));
    EXPECT_THAT(logAfter("touch:" + (root_ / "inside").string()), Contains("touch: allowed"));
    EXPECT_THAT(logAfter("read:" + (root_ / "inside").string()), Contains("read: allowed"));
}

TEST_F(JobRightsTest, onlyTheOutputsRootIsWritable) {
    if (!landlockThere()) GTEST_SKIP() << "this kernel has no Landlock";
    auto two = settings();
    const auto archive = directory_ / "archive";
    std::filesystem::create_directory(archive);
    std::ofstream(archive / "run") << "x";
    two.roots.push_back("archive=" + archive.string());
    startServer(two);
    EXPECT_THAT(logAfter("read:" + (archive / "run").string()), Contains("read: allowed"));
    EXPECT_THAT(logAfter("touch:" + (archive / "run").string()), Contains("touch: Permission denied"));
}

TEST_F(JobRightsTest, itHasNoNetwork) {
    startServer();
    EXPECT_THAT(logAfter("socket:"), Contains("socket: Operation not permitted"));
}

TEST_F(JobRightsTest, itsLimitsAreSet) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer takes more memory than this test allows";
#endif
    auto limited = settings();
    limited.memory = std::uint64_t{1} << 30;
    startServer(limited);
    // 1 GiB and half a GiB of headroom; five steps nicer than this process.
    const auto nice = std::min(19, getpriority(PRIO_PROCESS, 0) + 5);
    EXPECT_THAT(logAfter("limits:"),
                Contains("core 0 data 1610612736 nice " + std::to_string(nice) + " term true"));
}

}  // namespace
}  // namespace mote::server
