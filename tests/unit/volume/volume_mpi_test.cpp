// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-prep volume under mpirun: the same bytes for any number of ranks, and nothing left where one of them
// fails.
#include <gmock/gmock.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <random>

#include "storage/hash.h"
#include "tests/e2e/process.h"
#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::Each;
using testing::HasSubstr;
using testing::Not;

constexpr int nx = 70, ny = 60, nz = 150;

class VolumeMpi : public testing::Test {
  protected:
    void SetUp() override {
        std::mt19937 random(11);
        for (int z = 0; z < nz; ++z) {
            for (int y = 0; y < ny; ++y) {
                for (int x = 0; x < nx; ++x) {
                    const bool ball = std::hypot(x - 35.0, y - 30.0, (z - 75.0) / 2.0) < 25.0;
                    bytes_ += static_cast<char>(60 + (ball ? 90 : 0) + static_cast<int>(random() % 30));
                }
            }
        }
        std::ofstream(folder_ / "a.raw", std::ios::binary) << bytes_;
    }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    std::vector<std::string> job(int ranks, const std::string& input, const std::string& out,
                                 const std::vector<std::string>& more) const {
        std::vector<std::string> arguments{"-n",
                                           std::to_string(ranks),
                                           (fs::path(MOTE_BIN) / "mote-prep").string(),
                                           "volume",
                                           path(input),
                                           "--dimensions",
                                           std::to_string(nx),
                                           std::to_string(ny),
                                           std::to_string(nz),
                                           "--quiet",
                                           "--out",
                                           path(out)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    }
    Finished run(int ranks, const std::string& input, const std::vector<std::string>& more) const {
        return runProcess(MOTE_MPIRUN, job(ranks, input, "a.mote", more), mpiEnvironment(folder_.path()));
    }
    /// Of all of the dataset's files.
    std::string hashes() const {
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(folder_ / "a.mote")) files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        std::string all;
        for (const auto& file : files) {
            const auto hash = storage::hashFile(file);
            all += file.filename().string() + " " + (hash.ok() ? hash->xxh3_128 : "cannot be read") + "\n";
        }
        return all;
    }
    /// Datasets, whole and unfinished.
    std::vector<std::string> datasets() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder_.path())) {
            const auto name = entry.path().filename().string();
            if (name.find(".mote") != std::string::npos) names.push_back(name);
        }
        return names;
    }

    TempDir folder_;
    std::string bytes_;
};

/// 150 slices are five layers of bricks, the last of them thin; of six ranks one has none.
TEST_F(VolumeMpi, TheSameBytesForAnyNumberOfRanksAndThreads) {
    const std::vector<std::vector<std::string>> jobs{
        {"--low", "20", "--max-points", "5000", "--representation", "both", "--filter", "under:0.1"},
        {"--low", "16", "--threshold", "0.02", "--representation", "both", "--error-grid", "90",
         "--point-bytes", "6"},
        {"--low", "4", "--threshold", "0", "--filter", "box"},
    };
    for (const auto& options : jobs) {
        std::string expected;
        for (const int ranks : {1, 2, 6}) {
            SCOPED_TRACE(ranks);
            auto more = options;
            more.insert(more.end(), {"--threads", ranks == 2 ? "2" : "1"});
            const auto made = run(ranks, "a.raw", more);
            ASSERT_EQ(made.status, 0) << made.errors;
            const auto all = hashes();
            if (expected.empty()) expected = all;
            EXPECT_EQ(all, expected);
            fs::remove_all(folder_ / "a.mote");
        }
    }
}

/// Each rank reads a compressed file from its beginning; the last one alone meets its end.
TEST_F(VolumeMpi, AFileCutShortIsSaidOnceAndLeavesNothing) {
    const auto file = ::gzopen(path("b.raw.gz").c_str(), "wb1");
    ASSERT_EQ(::gzwrite(file, bytes_.data(), static_cast<unsigned>(bytes_.size())),
              static_cast<int>(bytes_.size()));
    ASSERT_EQ(::gzclose(file), Z_OK);
    const std::vector<std::string> options{"--low", "20", "--threshold", "0.1"};
    EXPECT_EQ(run(2, "b.raw.gz", options).status, 0);
    fs::remove_all(folder_ / "a.mote");
    fs::resize_file(folder_ / "b.raw.gz", fs::file_size(folder_ / "b.raw.gz") * 9 / 10);
    const auto wrong = run(3, "b.raw.gz", options);
    EXPECT_NE(wrong.status, 0);
    const auto said = wrong.errors.find("mote-prep: ");
    ASSERT_NE(said, std::string::npos) << wrong.errors;
    EXPECT_EQ(wrong.errors.find("mote-prep: ", said + 1), std::string::npos) << wrong.errors;
    EXPECT_THAT(wrong.errors, HasSubstr("b.raw.gz"));
    EXPECT_TRUE(datasets().empty());
}

TEST_F(VolumeMpi, CancelledItLeavesNothing) {
    Process launcher(MOTE_MPIRUN, job(3, "a.raw", "a.mote", {"--low", "4", "--threshold", "0"}),
                     mpiEnvironment(folder_.path()));
    // Once the folder is there the job is under way.
    while (datasets().empty()) ASSERT_FALSE(launcher.wait(std::chrono::milliseconds(1)).has_value());
    const auto ranks = childrenOf(launcher.id());
    launcher.signal(SIGTERM);
    ASSERT_TRUE(launcher.wait().has_value());
    for (const auto rank : ranks) EXPECT_TRUE(waitForEnd(rank));
    // It may have been done before it heard.
    EXPECT_THAT(datasets(), Each(Not(HasSubstr("partial"))));
}

}  // namespace
}  // namespace mote::test
