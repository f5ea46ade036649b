// SPDX-License-Identifier: GPL-3.0-or-later
//
// The helper itself: a test that trusts it must be able to fail.
#include "tests/e2e/process.h"

#include <gtest/gtest.h>

#include <csignal>

namespace mote::test {
namespace {

TEST(ProcessTest, TellsStatusOutputAndErrorsApart) {
    const auto done = runProcess("/bin/sh", {"-c", "echo out; echo err >&2; exit 3"});
    EXPECT_EQ(done.status, 3);
    EXPECT_EQ(done.output, "out\n");
    EXPECT_EQ(done.errors, "err\n");
}

TEST(ProcessTest, ASignalIsNoSuccess) {
    EXPECT_EQ(runProcess("/bin/sh", {"-c", "kill -9 $$"}).status, 128 + SIGKILL);
    EXPECT_EQ(runProcess("/no/such/program", {}).status, 127);
}

TEST(ProcessTest, WaitsForOutputAndEnds) {
    Process process("/bin/sh", {"-c", "echo first; echo ready now; read x; sleep 1000"});
    EXPECT_TRUE(process.waitForOutput("ready"));
    EXPECT_FALSE(process.waitForOutput("never", Process::Timeout(1)));
    process.signal(SIGTERM);
    EXPECT_EQ(process.wait(), 128 + SIGTERM);
    EXPECT_FALSE(process.waitForOutput("never"));
}

TEST(ProcessTest, GivesUpInTime) {
    Process process("/bin/sleep", {"1000"});
    EXPECT_FALSE(process.wait(Process::Timeout(1)).has_value());
}

TEST(ProcessTest, KnowsWhetherAnotherProcessHasEnded) {
    Process process("/bin/sleep", {"1000"});
    EXPECT_FALSE(waitForEnd(process.id(), Process::Timeout(1)));
    process.signal(SIGKILL);
    EXPECT_TRUE(waitForEnd(process.id()));
}

TEST(ProcessTest, PassesEnvironmentAndLimits) {
    EXPECT_EQ(runProcess("/bin/sh", {"-c", "echo $MOTE_X"}, {{{"MOTE_X", "7"}}, {}}).output, "7\n");
    EXPECT_EQ(runProcess("/bin/sh", {"-c", "ulimit -f"}, {{}, 1024}).output, "2\n");
}

TEST(ProcessTest, ReadsMoreThanAPipeHolds) {
    const auto done = runProcess("/bin/sh", {"-c", "head -c 1000000 /dev/zero | tr '\\0' x"});
    EXPECT_EQ(done.output.size(), 1000000U);
}

}  // namespace
}  // namespace mote::test
