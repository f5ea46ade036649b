// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-supervise by itself: nothing of a job outlives it, and where the kernel cannot confine a job none
// runs.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <functional>
#include <sstream>

#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

using ::testing::HasSubstr;

std::string contentOf(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

/// Runs it to its end in `folder`, which then holds its log and result; `first` is called in its process.
void supervise(
    const std::filesystem::path& folder, std::vector<std::string> words,
    const std::function<void()>& first = [] {}) {
    words.insert(words.begin(), {MOTE_BIN "/mote-supervise", "--directory", folder.string()});
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::array<int, 2> gate{};
    ASSERT_EQ(pipe(gate.data()), 0);
    ASSERT_EQ(write(gate[1], "g", 1), 1);
    const pid_t child = fork();
    if (child == 0) {
        dup2(open((folder / "log").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600), STDERR_FILENO);
        dup2(gate[0], 3);
        first();
        execv(arguments[0], arguments.data());
        _exit(99);
    }
    for (const int each : gate) close(each);
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
}

/// As on a kernel that has no such call.
void deny(int call) {
    const auto filter = seccomp_init(SCMP_ACT_ALLOW);
    seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), call, 0);
    seccomp_load(filter);
    seccomp_release(filter);
}

void withoutLandlock() {
    deny(SYS_landlock_create_ruleset);
}

void withoutSeccomp() {
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    const auto filter = seccomp_init(SCMP_ACT_ALLOW);
    seccomp_rule_add(filter, SCMP_ACT_ERRNO(EINVAL), SCMP_SYS(prctl), 1,
                     SCMP_A0_32(SCMP_CMP_EQ, PR_SET_SECCOMP));
    seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(seccomp), 0);
    seccomp_load(filter);
    seccomp_release(filter);
}

TEST(SuperviseConfine, WhereTheKernelCannotNoJobRuns) {
    for (const auto& kernel : {withoutLandlock, withoutSeccomp}) {
        const test::TempDir folder;
        supervise(folder.path(), {"--", "/bin/true"}, kernel);
        EXPECT_EQ(contentOf(folder / "result"), "exit 127\n");
        EXPECT_THAT(contentOf(folder / "log"), HasSubstr("jobs cannot be confined on this machine"));
        EXPECT_THAT(contentOf(folder / "log"), HasSubstr("--allow-unconfined-jobs"));
    }
}

TEST(SuperviseConfine, WhereThatIsAllowedItRunsAndSaysSo) {
    for (const auto& kernel : {withoutLandlock, withoutSeccomp}) {
        const test::TempDir folder;
        supervise(folder.path(), {"--unconfined", "allowed", "--", "/bin/true"}, kernel);
        EXPECT_EQ(contentOf(folder / "result"), "exit 0\n");
        EXPECT_THAT(contentOf(folder / "log"), HasSubstr("note: this job is not confined"));
    }
}

/// Of a launcher, which may have processes: a child in a session of its own, and its child.
TEST(SuperviseConfine, WhatALauncherLeavesBehindIsKilled) {
    const test::TempDir folder;
    // Both hold the pipe's end: it is at its end once they are gone.
    std::array<int, 2> held{};
    ASSERT_EQ(pipe2(held.data(), O_CLOEXEC), 0);
    const auto script = "setsid sh -c 'sleep 600 & sleep 600' & setsid sleep 600 & echo left >&2";
    supervise(folder.path(), {"--launcher", "mpi", "--", "/bin/sh", "-c", script},
              [&] { dup2(held[1], STDOUT_FILENO); });
    close(held[1]);
    EXPECT_EQ(contentOf(folder / "result"), "exit 0\n") << contentOf(folder / "log");
    EXPECT_THAT(contentOf(folder / "log"), HasSubstr("left"));
    pollfd end{held[0], POLLIN, 0};
    EXPECT_EQ(poll(&end, 1, 0), 1) << "something of it still runs";
    close(held[0]);
}

TEST(SuperviseConfine, AnotherProgramHasNoChildren) {
    const test::TempDir folder;
    supervise(folder.path(), {"--", "/bin/sh", "-c", "/bin/true & wait; echo forked >&2"});
    EXPECT_NE(contentOf(folder / "result"), "exit 0\n");
    EXPECT_THAT(contentOf(folder / "log"), Not(HasSubstr("forked")));
}

}  // namespace
}  // namespace mote::server
