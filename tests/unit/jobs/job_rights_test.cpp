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
    std::vector<std::string> filmLogAfter(const std::string& script) {
        const auto done = waitForState(submitFilm(script + " exit:1"), State::FAILED);
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
    std::ofstream(root_ / "inside") << "x";
    EXPECT_THAT(logAfter("read:" + (root_ / "inside").string()), Contains("read: allowed"));
}

TEST_F(JobRightsTest, onlyItsDraftIsWritable) {
    if (!landlockThere()) GTEST_SKIP() << "this kernel has no Landlock";
    auto two = settings();
    const auto archive = directory_ / "archive";
    std::filesystem::create_directory(archive);
    std::ofstream(archive / "run") << "x";
    std::ofstream(root_ / "other.h5") << "x";
    two.roots.push_back("archive=" + archive.string());
    startServer(two);
    EXPECT_THAT(logAfter("read:" + (archive / "run").string()), Contains("read: allowed"));
    EXPECT_THAT(logAfter("touch:" + (archive / "run").string()), Contains("touch: Permission denied"));
    EXPECT_THAT(logAfter("touch:" + (root_ / "other.h5").string()), Contains("touch: Permission denied"));
    EXPECT_THAT(logAfter("touch:" + (root_ / "new").string()), Contains("touch: Permission denied"));
    waitForState(submit("publish:"), State::SUCCEEDED);
}

TEST_F(JobRightsTest, itHasNoNetwork) {
    startServer();
    EXPECT_THAT(logAfter("socket:"), Contains("socket: Function not implemented"));
}

TEST_F(JobRightsTest, itHasNoUnixSocketsEither) {
    startServer();
    EXPECT_THAT(logAfter("unix:"), Contains("unix: Function not implemented"));
}

TEST_F(JobRightsTest, aFilmReadsNoDataAndWritesItsFolderAlone) {
    if (!landlockThere()) GTEST_SKIP() << "this kernel has no Landlock";
    startServer();
    std::ofstream(root_ / "run.h5") << "x";
    std::ofstream(directory_ / "state/film/connection.json") << "{}";
    const auto log = filmLogAfter("read:" + (root_ / "run.h5").string());
    EXPECT_THAT(log, Contains("read: Permission denied"));
    EXPECT_THAT(filmLogAfter("touch:" + (root_ / "new").string()), Contains("touch: Permission denied"));
    EXPECT_THAT(filmLogAfter("touch:" + (directory_ / "state/film/connection.json").string()),
                Contains("touch: Permission denied"));
    EXPECT_THAT(filmLogAfter("read:" + (directory_ / "state/jobs.sqlite").string()),
                Contains("read: Permission denied"));
    EXPECT_THAT(filmLogAfter("connection:"), Contains("connection: allowed"));
    EXPECT_FALSE(std::filesystem::exists(root_ / "new"));
}

/// The next server writes another file of this name.
TEST_F(JobRightsTest, aFilmReadsTheConnectionFileOfTheNextServerToo) {
    startServer();
    const auto file = directory_ / "state/film/connection.json";
    std::ofstream(file) << "{}";
    const auto id = submitFilm("phase:on wait:go connection: exit:1");
    waitForPhase(id, "on");
    std::filesystem::remove(file);
    std::ofstream(file) << "{}";
    releaseFilm(id, "go");
    const auto done = waitForState(id, State::FAILED);
    EXPECT_THAT(done.log(), Contains("connection: allowed"));
}

TEST_F(JobRightsTest, aFilmMayOpenUnixSocketsAndNoOthers) {
    startServer();
    EXPECT_THAT(filmLogAfter("unix:"), Contains("unix: allowed"));
    EXPECT_THAT(filmLogAfter("socket:"), Contains("socket: Function not implemented"));
}

TEST_F(JobRightsTest, aFilmIsTheNicestOfAll) {
    startServer();
    const auto nice = std::to_string(std::min(19, getpriority(PRIO_PROCESS, 0) + 15));
    const auto log = filmLogAfter("limits:");
    EXPECT_THAT(log, Contains(HasSubstr(" nice " + nice + " term true")));
    if (std::filesystem::exists("/proc/self/autogroup")) {
        EXPECT_THAT(log, Contains("session nice " + nice));
    }
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
