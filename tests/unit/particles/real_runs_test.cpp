// SPDX-License-Identifier: GPL-3.0-or-later
//
// Every particle of every run that other people's programs wrote, through the readers and the job and back.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>

#include "preprocess/particles/particles_job.h"
#include "storage/manifest.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/account.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

struct Run {
    std::string name;
    std::string input;  ///< a file, or a folder whose fort.1??.txt.gz are the run
    std::array<const char*, 3> axes;
    std::vector<std::uint64_t> rows;  ///< by step
    std::vector<std::uint64_t> lost;
};

void PrintTo(const Run& run, std::ostream* out) {
    *out << run.name;
}

class RealRun : public testing::TestWithParam<Run> {
  protected:
    static std::vector<fs::path> inputs() {
        const auto path = fs::path(MOTE_SHARED_DATA) / "particles" / GetParam().input;
        if (!fs::is_directory(path)) return {path};
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(path)) {
            if (entry.path().filename().string().starts_with("fort.1") && entry.path().extension() == ".gz") {
                files.push_back(entry.path());
            }
        }
        std::sort(files.begin(), files.end());
        return files;
    }
};

TEST_P(RealRun, EveryParticleIsAccountedFor) {
    const auto& run = GetParam();
    const auto files = inputs();
    if (files.empty() || !fs::exists(files.front())) GTEST_SKIP() << "the real file is not here";
    const test::TempDir dir;
    proto::JobRequest request;
    auto& job = *request.mutable_particles();
    for (const auto& file : files) job.add_inputs(file.string());
    for (const char* axis : run.axes) job.add_axes(axis);
    test::QuietProgress progress;
    const auto made = runParticlesJob(request, files, dir / "a.mote", {}, progress);
    ASSERT_TRUE(made.ok()) << made.error().toString();
    const auto& steps = made->particles().steps();
    ASSERT_EQ(static_cast<std::size_t>(steps.size()), run.rows.size());
    for (int i = 0; i < steps.size(); ++i) {
        const auto at = static_cast<std::size_t>(i);
        const auto& step = steps[i];
        EXPECT_EQ(step.particles() + step.lost() + step.invalid() + step.outside(), run.rows[at]);
        EXPECT_EQ(step.lost(), run.lost[at]);
        EXPECT_EQ(step.invalid(), 0U);
        // None of these beams has an outlier by the rule.
        EXPECT_EQ(step.outside(), 0U);
    }
    auto source = openParticleSource(job, files, progress);
    ASSERT_TRUE(source.ok());
    test::expectAccounted(dir / "a.mote", job, **source);
    EXPECT_TRUE(storage::verifyDataset(dir / "a.mote").empty());
}

// Rows and losses as in the lists of contents beside the files.
const std::vector<std::uint64_t> impactRows{20000, 20000, 20000, 19970, 19892, 19427, 18363,
                                            18358, 18358, 18358, 18358, 18358, 18358};
const std::vector<std::uint64_t> noneLost(13, 0);

INSTANTIATE_TEST_SUITE_P(
    Files, RealRun,
    testing::Values(Run{"BmadTransverse", "bmad_particles.h5", {"x", "px", "y"}, {10000}, {0}},
                    Run{"BmadDerived", "bmad_particles.h5", {"delta", "t", "xp"}, {10000}, {0}},
                    Run{"AstraLosesSix", "astra_particles.h5", {"x", "y", "z"}, {998, 998}, {6, 6}},
                    Run{"AstraDerived", "astra_particles.h5", {"r", "pr", "theta"}, {998, 998}, {6, 6}},
                    Run{"PicongpuPlace", "picongpu_lwfa_000550.h5", {"x", "y", "z"}, {35915}, {0}},
                    Run{"PicongpuEnergy", "picongpu_lwfa_000550.h5", {"y", "energy", "px"}, {35915}, {0}},
                    Run{"ImpactzPhaseSpace", "impactz_dtl_20k", {"x", "px", "y"}, impactRows, noneLost},
                    Run{"ImpactzEnergy", "impactz_dtl_20k", {"x", "yp", "energy"}, impactRows, noneLost}),
    [](const auto& one) { return one.param.name; });

/// The same way without any file of other people: a run that the test writes as a table.
TEST(RealRunFallback, ATableThroughReaderAndJob) {
    const test::TempDir dir;
    {
        std::ofstream table(dir / "run.csv");
        table << "x,y,z,px,py,pz\n";
        for (int i = 0; i < 500; ++i) {
            table << 1e-3 * (i % 37) << ',' << 1e-3 * (i % 41) << ',' << 1e-3 * i << ',' << i % 7
                  << ",0,1e6\n";
        }
    }
    proto::JobRequest request;
    auto& job = *request.mutable_particles();
    job.add_inputs((dir / "run.csv").string());
    for (const char* axis : {"x", "y", "px"}) job.add_axes(axis);
    test::QuietProgress progress;
    const auto made = runParticlesJob(request, {dir / "run.csv"}, dir / "a.mote", {}, progress);
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_EQ(made->particles().steps(0).particles(), 500U);
    auto source = openParticleSource(job, {dir / "run.csv"}, progress);
    ASSERT_TRUE(source.ok());
    test::expectAccounted(dir / "a.mote", job, **source);
}

}  // namespace
}  // namespace mote::prep
