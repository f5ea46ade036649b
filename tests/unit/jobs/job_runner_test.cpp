// SPDX-License-Identifier: GPL-3.0-or-later
//
// Runners that the machine lacks the programs of, and the words with which several ranks are started.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "server/jobs/job_store.h"
#include "server/jobs/run_orders.h"
#include "server/jobs/runner.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::HasSubstr;

constexpr const char* kId = "00000000deadbeef";

/// PATH holds this folder alone, for as long as the object lives.
class OnlyPath {
  public:
    explicit OnlyPath(const std::filesystem::path& folder) : before_(std::getenv("PATH")) {
        setenv("PATH", folder.c_str(), 1);
    }
    ~OnlyPath() { setenv("PATH", before_.c_str(), 1); }
    OnlyPath(const OnlyPath&) = delete;
    OnlyPath& operator=(const OnlyPath&) = delete;

  private:
    const std::string before_;
};

class JobRunnerTest : public JobTest {
  protected:
    JobSettings with(const std::string& runner, unsigned ranks = 1) const {
        auto changed = settings();
        changed.runner = runner;
        changed.ranks = ranks;
        return changed;
    }
    void addProgram(const std::string& name) const {
        std::ofstream(directory_ / name) << "#!/bin/sh\n";
        std::filesystem::permissions(directory_ / name, std::filesystem::perms::owner_all);
    }
    /// What a server leaves whose job runs in Slurm.
    void leaveJobOfSlurm() const {
        std::filesystem::create_directories(directory_ / "state");
        JobRecord record;
        record.status.set_id(kId);
        record.status.set_state(State::RUNNING);
        *record.status.mutable_request() = request("publish:");
        record.attempts = 1;
        record.handle = "slurm 4711";
        auto store = JobStore::open(directory_ / "state/jobs.sqlite");
        ASSERT_TRUE(store.ok());
        ASSERT_TRUE(store->insert(record).ok());
    }
};

TEST_F(JobRunnerTest, ItsProgramsMustBeThere) {
    const OnlyPath path(directory_);
    EXPECT_TRUE(checkRunner("local", 1).ok());
    EXPECT_EQ(checkRunner("pbs", 1).error().code, ErrorCode::invalidArgument);
    EXPECT_EQ(checkRunner("mpi", 2).error().toString(),
              "--runner: \"mpi\" needs mpirun, which is not in PATH");
    for (const char* name : {"sbatch", "squeue", "scontrol", "scancel"}) {
        EXPECT_THAT(checkRunner("slurm", 1).error().message, HasSubstr(std::string("needs ") + name));
        addProgram(name);
    }
    EXPECT_TRUE(checkRunner("slurm", 1).ok());
    EXPECT_THAT(checkRunner("slurm", 2).error().message, HasSubstr("needs mpirun"));
    addProgram("mpirun");
    EXPECT_TRUE(checkRunner("slurm", 2).ok());
    EXPECT_TRUE(checkRunner("mpi", 2).ok());
}

TEST_F(JobRunnerTest, AServerDoesNotBeginWithoutThem) {
    const OnlyPath path(directory_);
    asio::io_context context;
    JobQueue queue(context, with("slurm"));
    const auto started = queue.start();
    ASSERT_FALSE(started.ok());
    EXPECT_THAT(started.error().toString(), HasSubstr("sbatch"));
}

TEST_F(JobRunnerTest, AJobOfASlurmThatIsGoneIsLostAndTheServerBegins) {
    leaveJobOfSlurm();
    const OnlyPath path(directory_);
    startServer();
    const auto lost = queue_->find(kId);
    ASSERT_TRUE(lost.ok());
    EXPECT_EQ(lost->state(), State::FAILED) << "it may still run: nobody begins it again";
    EXPECT_THAT(lost->error(), HasSubstr("Slurm"));
    EXPECT_EQ(waitForState(submit("publish:"), State::SUCCEEDED).runner(), "local");
}

TEST_F(JobRunnerTest, WhatItHadLeftInItsFilesIsKnown) {
    leaveJobOfSlurm();
    const auto folder = directory_ / "state/jobs" / kId;
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "result") << "exit 0";
    std::ofstream(root_ / "run.h5") << "x";
    const OnlyPath path(directory_);
    startServer();
    EXPECT_EQ(queue_->find(kId)->state(), State::SUCCEEDED);
}

/// The words for a job of this runner.
RunOrder orderFor(const JobSettings& settings, const proto::JobRequest& request) {
    const auto roots = storage::Roots::parse(settings.roots);
    EXPECT_TRUE(roots.ok());
    return prepOrder(settings, *roots, settings.stateDirectory / "jobs" / kId, ranksOf(settings, request));
}

TEST_F(JobRunnerTest, SeveralRanksShareTheMemoryAndAreStartedByMpirun) {
    proto::JobRequest plot;
    plot.mutable_particles()->add_inputs("data/run.h5");
    auto two = with("mpi", 2);
    two.memory = std::uint64_t{4} << 30;
    two.threads = 3;
    const auto order = orderFor(two, plot);
    EXPECT_TRUE(order.launcher);
    EXPECT_EQ(order.program.at(1), "TMPDIR=" + order.scratch.string()) << "where alone the job may write";
    EXPECT_EQ(order.program.at(2), "HWLOC_COMPONENTS=-gl") << "an X server that ends would end mpirun";
    EXPECT_THAT(order.program.at(3), HasSubstr("mpirun"));
    const auto valueOf = [&](const std::string& option) {
        const auto found = std::ranges::find(order.program, option);
        return found == order.program.end() ? "" : *std::next(found);
    };
    EXPECT_EQ(valueOf("-n"), "2");
    EXPECT_EQ(valueOf("--memory"), std::to_string(std::uint64_t{2} << 30));
    EXPECT_EQ(order.memory, two.memory) << "of all that the job starts";
    EXPECT_EQ(order.cores, 6U);
    EXPECT_EQ(order.scratch.parent_path(), order.directory) << "nobody else's";
}

TEST_F(JobRunnerTest, WhatCannotHaveRanksRunsAlone) {
    proto::JobRequest plot;
    plot.mutable_particles()->add_inputs("data/run.h5");
    EXPECT_FALSE(orderFor(with("local", 2), plot).launcher);
    EXPECT_FALSE(orderFor(with("mpi", 2), request("a run")).launcher) << "it is one process by its nature";
}

}  // namespace
}  // namespace mote::server
