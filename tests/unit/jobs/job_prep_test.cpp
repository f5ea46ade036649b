// SPDX-License-Identifier: GPL-3.0-or-later
//
// The queue with the real mote-prep, under the rights that it has on a server.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "server/jobs/runner.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::HasSubstr;

class JobPrepTest : public JobTest {
  protected:
    JobPrepTest() { startServer(realSettings()); }

    JobSettings realSettings() const {
        auto real = settings();
        real.prep = MOTE_BIN "/mote-prep";
        real.threads = 1;
        return real;
    }

    std::string submitRun(std::uint64_t particles, std::uint32_t steps = 2) {
        auto run = request("a small beam");
        run.mutable_synth_beam()->set_particles(particles);
        run.mutable_synth_beam()->set_steps(steps);
        run.mutable_synth_beam()->set_seed(1);
        const auto status = queue_->submit(run);
        EXPECT_TRUE(status.ok()) << status.error().toString();
        return status.value().id();
    }

    std::string submitPlot(const std::string& output) {
        proto::JobRequest plot;
        plot.set_output(output);
        plot.mutable_particles()->add_inputs("data/run.h5");
        for (const char* axis : {"x", "px", "y"}) plot.mutable_particles()->add_axes(axis);
        const auto status = queue_->submit(plot);
        EXPECT_TRUE(status.ok()) << status.error().toString();
        return status.value().id();
    }

    proto::JobStatus waitForTheEnd(const std::string& id) {
        return waitUntil(id, [](const auto& status) { return status.state() > State::RUNNING; });
    }

    /// Names in the root, drafts too.
    std::vector<std::string> rootNames() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(root_)) {
            names.push_back(entry.path().filename());
        }
        std::sort(names.begin(), names.end());
        return names;
    }
};

TEST_F(JobPrepTest, aRunIsMadeAndPlotted) {
    const auto run = waitForTheEnd(submitRun(2000));
    ASSERT_EQ(run.state(), State::SUCCEEDED) << run.ShortDebugString();
    const auto plot = waitForTheEnd(submitPlot("data/plot.mote"));
    ASSERT_EQ(plot.state(), State::SUCCEEDED) << plot.ShortDebugString();
    EXPECT_TRUE(std::filesystem::exists(root_ / "plot.mote/manifest.json"));
    EXPECT_EQ(rootNames(), (std::vector<std::string>{"plot.mote", "run.h5"}));
}

TEST_F(JobPrepTest, aBrokenFileIsSaidInOneSentence) {
    ASSERT_EQ(waitForTheEnd(submitRun(2000)).state(), State::SUCCEEDED);
    std::filesystem::resize_file(root_ / "run.h5", std::filesystem::file_size(root_ / "run.h5") / 3);
    const auto plot = waitForTheEnd(submitPlot("data/plot.mote"));
    EXPECT_EQ(plot.state(), State::FAILED);
    EXPECT_THAT(plot.error(), HasSubstr("run.h5"));
    EXPECT_EQ(rootNames(), std::vector<std::string>{"run.h5"});
}

TEST_F(JobPrepTest, aCancelledRunLeavesNothing) {
    // Some 20 s of work for one thread and 440 MB; it is cancelled in the first of its steps.
    const auto id = submitRun(500'000, 20);
    waitUntil(id,
              [](const auto& status) { return status.phase() != "waiting" && status.phase() != "starting"; });
    ASSERT_TRUE(queue_->cancel(id).ok());
    const auto cancelled = waitForTheEnd(id);
    EXPECT_EQ(cancelled.state(), State::CANCELLED) << cancelled.ShortDebugString();
    EXPECT_EQ(rootNames(), std::vector<std::string>{});
}

/// Two ranks under the real mpirun, which the job's limits must let work.
class JobRanksTest : public JobPrepTest {
  protected:
    void SetUp() override {
        auto ranks = realSettings();
        ranks.runner = "mpi";
        ranks.ranks = 2;
        if (!checkRunner("mpi", 2).ok()) GTEST_SKIP() << "there is no mpirun";
        ASSERT_EQ(waitForTheEnd(submitRun(2000)).state(), State::SUCCEEDED);
        ASSERT_EQ(waitForTheEnd(submitPlot("data/alone.mote")).state(), State::SUCCEEDED);
        startServer(ranks);
    }
    static std::string bytesOf(const std::filesystem::path& file) {
        std::ifstream stream(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
};

TEST_F(JobRanksTest, theyMakeTheSameBytesAsOneProcess) {
    const auto plot = waitForTheEnd(submitPlot("data/ranks.mote"));
    ASSERT_EQ(plot.state(), State::SUCCEEDED) << plot.ShortDebugString();
    EXPECT_EQ(plot.runner(), "mpi");
    EXPECT_EQ(rootNames(), (std::vector<std::string>{"alone.mote", "ranks.mote", "run.h5"}));
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(root_ / "alone.mote")) {
        ++files;
        EXPECT_TRUE(bytesOf(entry.path()) == bytesOf(root_ / "ranks.mote" / entry.path().filename()))
            << entry.path().filename();
    }
    EXPECT_GT(files, 0);
}

TEST_F(JobRanksTest, whatOneOfThemSaysIsTheJobsError) {
    std::filesystem::resize_file(root_ / "run.h5", std::filesystem::file_size(root_ / "run.h5") / 3);
    const auto plot = waitForTheEnd(submitPlot("data/ranks.mote"));
    EXPECT_EQ(plot.state(), State::FAILED);
    EXPECT_THAT(plot.error(), HasSubstr("run.h5")) << "and no word of mpirun's";
    EXPECT_EQ(rootNames(), (std::vector<std::string>{"alone.mote", "run.h5"}));
}

}  // namespace
}  // namespace mote::server
