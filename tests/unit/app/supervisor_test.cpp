// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a supervisor makes of the ways in which a process ends. Children end by _Exit: what they share with
// the test's process must not be torn down twice.
#include "server/app/supervisor.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <list>
#include <new>
#include <vector>

namespace mote::server {
namespace {

TEST(Supervisor, AnExitCodeIsPassedOn) {
    CrashRecord record;
    EXPECT_EQ(supervise(record, [](bool) -> int { std::_Exit(7); }), 7);
}

TEST(Supervisor, WhatASignalEndsIsStartedAgain) {
    CrashRecord record;
    const int code = supervise(record, [&](bool again) -> int {
        record.ready();
        if (again) std::_Exit(9);
        std::signal(SIGABRT, SIG_DFL);
        ::raise(SIGKILL);
        std::_Exit(1);
    });
    EXPECT_EQ(code, 9);
}

/// First little is asked for where there is nothing, then much.
TEST(Supervisor, WithoutMemoryForLittleAnotherServes) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "it has its own malloc, which ends the process itself";
#endif
    CrashRecord record;
    const int code = supervise(record, [&](bool again) -> int {
        std::signal(SIGABRT, SIG_DFL);
        record.ready();
        endWithoutMemory(record);
        const rlimit none{0, RLIM_INFINITY};
        ::setrlimit(RLIMIT_AS, &none);
        std::list<std::vector<char>> all;
        try {
            for (;;) all.emplace_back(again ? littleMemory : littleMemory / 1000);
        } catch (const std::bad_alloc&) {
            std::_Exit(again ? 9 : 1);
        }
    });
    EXPECT_EQ(code, 9);
}

TEST(Supervisor, WhatWasNeverReadyIsNotTriedAgain) {
    CrashRecord record;
    EXPECT_EQ(supervise(record,
                        [](bool) -> int {
                            ::raise(SIGKILL);
                            std::_Exit(1);
                        }),
              128 + SIGKILL);
}

TEST(Supervisor, TheNextProcessKnowsWhichViewEndedTheOthers) {
    CrashRecord record;
    const int code = supervise(record, [&](bool) -> int {
        record.ready();
        const unsigned deaths = record.deaths("a view");
        if (deaths == refusedAfterDeaths) std::_Exit(static_cast<int>(10 + deaths));
        record.begin("a view");
        ::raise(SIGKILL);
        std::_Exit(1);
    });
    EXPECT_EQ(code, 12);
}

/// In a process of its own, which is then asked to end.
TEST(Supervisor, PassesASignalOnAndEndsWithItsChild) {
#ifdef __SANITIZE_THREAD__
    GTEST_SKIP() << "it keeps signals back while a process waits for its child";
#endif
    const pid_t supervisor = ::fork();
    if (supervisor == 0) {
        CrashRecord record;
        std::_Exit(supervise(record, [&](bool again) -> int {
            if (again) std::_Exit(1);
            record.ready();
            sigset_t asked;
            ::sigemptyset(&asked);
            ::sigaddset(&asked, SIGTERM);
            ::sigprocmask(SIG_BLOCK, &asked, nullptr);
            ::kill(::getppid(), SIGTERM);
            int number = 0;
            ::sigwait(&asked, &number);
            std::_Exit(number == SIGTERM ? 5 : 6);
        }));
    }
    int status = 0;
    ASSERT_EQ(::waitpid(supervisor, &status, 0), supervisor);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 5);
}

}  // namespace
}  // namespace mote::server
