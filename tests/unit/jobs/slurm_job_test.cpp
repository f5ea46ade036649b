// SPDX-License-Identifier: GPL-3.0-or-later
//
// Jobs in Slurm: run beneath slurm_cluster.py, against its slurmctld and slurmd.
#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <memory>

#include "server/jobs/slurm_state.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

/// What a command of Slurm prints.
std::string ask(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string text;
    std::array<char, 4096> piece{};
    while (const auto got = fread(piece.data(), 1, piece.size(), pipe.get())) text.append(piece.data(), got);
    return text;
}

class SlurmJobTest : public JobTest {
  protected:
    void start() {
        auto slurm = settings();
        slurm.runner = "slurm";
        slurm.running = 4;
        slurm.memory = std::uint64_t{200} << 20;
        slurm.slurmPoll = std::chrono::milliseconds(100);
        startServer(slurm);
    }
    static std::map<std::uint64_t, SlurmState> jobs() {
        return parseQueue(ask("squeue --noheader --states=all '--format=%i|%T|%r'"));
    }
    /// All jobs that Slurm was ever given for this one, by their numbers.
    static std::map<std::uint64_t, SlurmState> runsOf(const std::string& id) {
        const auto names = parseNames(ask("squeue --noheader --states=all '--format=%i|%j'"));
        auto states = jobs();
        std::map<std::uint64_t, SlurmState> runs;
        const auto [begin, end] = names.equal_range("mote-" + id);
        for (auto name = begin; name != end; ++name) runs[name->second] = states[name->second];
        return runs;
    }
    static std::vector<std::string> logOf(const proto::JobStatus& status) {
        return {status.log().begin(), status.log().end()};
    }
};

TEST_F(SlurmJobTest, AJobRunsWithFewRightsAndSucceeds) {
    start();
    makeFifo("go");
    const auto id = submit("socket: half:on wait:go publish:");
    const auto working = waitForPhase(id, "on");
    EXPECT_EQ(working.runner(), "slurm");
    EXPECT_TRUE(jobs().contains(std::stoull(working.runner_id())));
    EXPECT_THAT(ask("squeue --noheader --format=%j"), HasSubstr("mote-" + id));
    release("go");
    const auto done = waitForState(id, State::SUCCEEDED);
    EXPECT_THAT(logOf(done), Contains("socket: Function not implemented"));
    EXPECT_TRUE(std::filesystem::exists(root_ / "run.h5"));
}

TEST_F(SlurmJobTest, AnotherServerFindsItByItsNumber) {
    start();
    makeFifo("go");
    const auto id = submit("phase:on wait:go publish:");
    const auto number = waitForPhase(id, "on").runner_id();
    start();
    EXPECT_EQ(queue_->find(id)->state(), State::RUNNING);
    release("go");
    EXPECT_EQ(waitForState(id, State::SUCCEEDED).runner_id(), number);
    EXPECT_EQ(runsOf(id).size(), 1U) << "it ran twice";
}

TEST_F(SlurmJobTest, AJobThatEndsBetweenTwoServersIsKnown) {
    start();
    makeFifo("go");
    const auto id = submit("phase:on wait:go print:no_beam exit:3");
    const auto number = std::stoull(waitForPhase(id, "on").runner_id());
    killServer();
    release("go");
    for (int i = 0; i < 1000 && !hasEnded(jobs()[number].state); ++i) {
    }
    start();
    EXPECT_EQ(waitForState(id, State::FAILED).error(), "no_beam");
}

TEST_F(SlurmJobTest, CancellingEndsWhatRunsAndWhatWaitsInSlurm) {
    start();
    makeFifo("never");
    std::vector<std::string> ids;
    for (const char* name : {"a", "b", "c"})
        ids.push_back(submit("draft: phase:on wait:never", std::string("data/") + name + ".h5"));
    for (const auto& id : ids) waitForState(id, State::RUNNING);
    waitForPhase(ids[0], "on");
    for (const auto& id : ids) ASSERT_TRUE(queue_->cancel(id).ok());
    for (const auto& id : ids) EXPECT_EQ(waitForState(id, State::CANCELLED).error(), "");
    std::filesystem::remove(root_ / "never");
    EXPECT_TRUE(std::filesystem::is_empty(root_)) << "a draft is still there";
    for (const auto& [number, job] : jobs()) EXPECT_TRUE(hasEnded(job.state)) << number << job.state;
}

TEST_F(SlurmJobTest, ARunEndsWithItsTime) {
    start();
    makeFifo("never");
    const auto status = queue_->submit(request("wait:never"), {false, 1});
    ASSERT_TRUE(status.ok());
    EXPECT_THAT(waitForState(status->id(), State::FAILED).error(), HasSubstr("time limit of 1 s"));
}

TEST_F(SlurmJobTest, WhatAKilledServerHadOnlyPreparedNeverRuns) {
    start();
    const auto id = submit("publish:");
    killServer();  // before it came to begin anything
    const auto mark = directory_ / "mark";
    const auto held = parseNumber(ask("sbatch --parsable --hold --output=/dev/null --job-name=mote-" + id +
                                      " --wrap 'touch " + mark.string() + "'"));
    ASSERT_TRUE(held.has_value());
    start();
    const auto done = waitForState(id, State::SUCCEEDED);
    waitUntil(id, [&](const auto&) {
        const bool ended = hasEnded(jobs()[*held].state);
        if (!ended) settle();
        return ended;
    });
    EXPECT_FALSE(std::filesystem::exists(mark));
    const auto runs = runsOf(id);
    EXPECT_EQ(runs.size(), 2U) << "the one that was held, and one more";
    EXPECT_TRUE(runs.contains(std::stoull(done.runner_id())));
}

TEST_F(SlurmJobTest, ANodeThatGoesDownInterruptsOnce) {
    start();
    makeFifo("never");
    const auto id = submit("phase:on wait:never publish:");
    const auto first = std::stoull(waitForPhase(id, "on").runner_id());
    ask("scontrol update NodeName=$(hostname -s) State=DOWN Reason=test");
    waitUntil(id, [](const auto& status) { return status.interrupted() == 1; });
    ask("scontrol update NodeName=$(hostname -s) State=RESUME");
    // Not before it waits, too: the first may be there still, and would take what is meant for the second.
    waitUntil(id, [&](const auto& status) {
        return status.phase() == "on" && status.runner_id() != std::to_string(first);
    });
    release("never");
    const auto done = waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(done.interrupted(), 1U);
    const auto runs = runsOf(id);
    EXPECT_EQ(runs.size(), 2U) << "it ran once more, and no oftener";
    ASSERT_TRUE(runs.contains(first));
    EXPECT_EQ(runs.at(first).state, "NODE_FAIL");
    EXPECT_TRUE(runs.contains(std::stoull(done.runner_id())));
}

/// They stand in the request's file, and there alone.
TEST_F(SlurmJobTest, WordsOfTheUserAreNoWordsForAShell) {
    start();
    const auto mark = directory_ / "mark";
    const std::string words[] = {
        "$(touch " + mark.string() + ")",    "`touch " + mark.string() + "`",  "-o" + mark.string(),
        "#SBATCH --output=" + mark.string(), "; touch " + mark.string() + ";", "%j%N\"'\\"};
    for (const auto& word : words) {
        const auto id = submit("publish: " + word, "data/-$(id)'\".h5");
        const auto status = waitForState(id, State::SUCCEEDED);
        EXPECT_EQ(status.request().title(), "publish: " + word);
        EXPECT_TRUE(std::filesystem::remove(root_ / "-$(id)'\".h5"));
        const auto shown = ask("scontrol show job " + status.runner_id() + "; scontrol write batch_script " +
                               status.runner_id() + " -");
        EXPECT_THAT(shown, Not(HasSubstr(word)));
    }
    EXPECT_FALSE(std::filesystem::exists(mark));
}

}  // namespace
}  // namespace mote::server
