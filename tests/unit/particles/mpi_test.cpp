// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-prep under mpirun: the same bytes for any number of ranks, and nothing left where one of them fails.
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <memory>

#include "storage/hash.h"
#include "tests/e2e/process.h"
#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Mpi : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TempDir>();
        const auto made = runProcess(
            fs::path(MOTE_BIN) / "mote-prep",
            {"synth", "beam", "--particles", "600000", "--steps", "2", "--quiet", "--out", path("run.h5")});
        ASSERT_EQ(made.status, 0) << made.errors;
    }
    static void TearDownTestSuite() { folder_.reset(); }

    static std::string path(const std::string& name) { return (folder_->path() / name).string(); }

    static ProcessOptions environment() { return mpiEnvironment(folder_->path()); }
    static std::vector<std::string> job(int ranks, const std::string& out,
                                        const std::vector<std::string>& more = {}) {
        std::vector<std::string> arguments{"-n",
                                           std::to_string(ranks),
                                           (fs::path(MOTE_BIN) / "mote-prep").string(),
                                           "particles",
                                           path("run.h5"),
                                           "--axes",
                                           "x,delta,y",
                                           "--quiet",
                                           "--out",
                                           path(out)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    }
    static std::string hashOf(const std::string& dataset) {
        std::string all;
        for (const char* name : {"manifest.json", "step-000000.h5", "step-000000.digest", "step-000001.h5",
                                 "step-000001.digest"}) {
            const auto hash = storage::hashFile(folder_->path() / dataset / name);
            all += hash.ok() ? hash->xxh3_128 + "\n" : hash.error().toString();
        }
        return all;
    }
    /// Datasets, whole and unfinished.
    static std::vector<std::string> datasets() {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder_->path())) {
            const auto name = entry.path().filename().string();
            if (name.find(".mote") != std::string::npos) names.push_back(name);
        }
        return names;
    }

    static std::unique_ptr<TempDir> folder_;
};

std::unique_ptr<TempDir> Mpi::folder_;

TEST_F(Mpi, TheSameBytesForAnyNumberOfRanksAndThreadsAndAnyMemory) {
    std::string expected;
    for (const int ranks : {1, 2, 3, 4}) {
        SCOPED_TRACE(ranks);
        const std::vector<std::string> threads{"--threads", ranks == 2 ? "2" : "1"};
        const auto made = runProcess(MOTE_MPIRUN, job(ranks, "a.mote", threads), environment());
        ASSERT_EQ(made.status, 0) << made.errors;
        const auto hash = hashOf("a.mote");
        if (expected.empty()) expected = hash;
        EXPECT_EQ(hash, expected);
        fs::remove_all(folder_->path() / "a.mote");
    }
}

TEST_F(Mpi, AnErrorIsSaidOnceAndLeavesNothing) {
    const auto wrong = runProcess(MOTE_MPIRUN, job(3, "b.mote", {"--steps", "7"}), environment());
    EXPECT_NE(wrong.status, 0);
    const auto said = wrong.errors.find("mote-prep: ");
    ASSERT_NE(said, std::string::npos) << wrong.errors;
    EXPECT_EQ(wrong.errors.find("mote-prep: ", said + 1), std::string::npos) << wrong.errors;
    EXPECT_TRUE(datasets().empty());
}

TEST_F(Mpi, OtherJobsRunInOneProcess) {
    auto arguments = job(2, "b.mote");
    arguments = {arguments[0],  arguments[1], arguments[2], "synth",     "beam",
                 "--particles", "100",        "--out",      path("b.h5")};
    const auto refused = runProcess(MOTE_MPIRUN, arguments, environment());
    EXPECT_NE(refused.status, 0);
    EXPECT_THAT(refused.errors, HasSubstr("one process"));
    EXPECT_FALSE(fs::exists(folder_->path() / "b.h5"));
}

class MpiKilled : public Mpi, public testing::WithParamInterface<std::size_t> {};

TEST_P(MpiKilled, TheJobFailsAsAWholeAndLeavesNothing) {
    Process launcher(MOTE_MPIRUN, job(3, "c.mote"), environment());
    // The job is under way once its folder is there, and far from done: nothing is written yet.
    while (datasets().empty()) ASSERT_FALSE(launcher.wait(std::chrono::milliseconds(1)).has_value());
    const auto ranks = childrenOf(launcher.id());
    ASSERT_EQ(ranks.size(), 3U);
    ::kill(ranks[GetParam()], SIGKILL);
    const auto status = launcher.wait();
    ASSERT_TRUE(status.has_value());
    EXPECT_NE(*status, 0);
    for (const auto rank : ranks) EXPECT_TRUE(waitForEnd(rank));
    EXPECT_TRUE(datasets().empty());
}

INSTANTIATE_TEST_SUITE_P(Rank, MpiKilled, testing::Values(0U, 2U));

}  // namespace
}  // namespace mote::test
