// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whole runs: what the file says, and that a seed gives the same bytes whatever the chunks and threads.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numeric>

#include "preprocess/synth/beam_run.h"
#include "recording_progress.h"
#include "run_file.h"
#include "tests/support/temp_dir.h"

namespace mote::prep {
namespace {

using test::RecordingProgress;
using test::RunFile;

std::string bytesOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

proto::SynthBeamJob runJob(std::uint64_t particles, std::uint32_t steps, std::uint64_t seed = 1) {
    proto::SynthBeamJob result;
    result.set_particles(particles);
    result.set_steps(steps);
    result.set_seed(seed);
    return result;
}

std::string run(const test::TempDir& folder, const char* name, const BeamRun& options, int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    RecordingProgress progress;
    const auto plan = planChannel(mismatched({}, 1.5), 3);
    EXPECT_TRUE(writeBeamRun(*plan, options, folder / name, progress).ok());
    return bytesOf(folder / name);
}

TEST(Run, chunksAndThreadsLeaveNoTrace) {
    const test::TempDir folder;
    const std::string whole = run(folder, "whole", {10'000, 42, 1 << 18}, 1);
    ASSERT_GT(whole.size(), 3u * 10'000 * 44);
    EXPECT_TRUE(run(folder, "again", {10'000, 42, 1 << 18}, 1) == whole);
    EXPECT_TRUE(run(folder, "threads", {10'000, 42, 1 << 18}, 2) == whole);
    EXPECT_TRUE(run(folder, "chunks", {10'000, 42, 4099}, 2) == whole);
    EXPECT_TRUE(run(folder, "seed", {10'000, 43, 1 << 18}, 2) != whole);
}

TEST(Run, aParticleDoesNotDependOnHowManyThereAre) {
    const test::TempDir folder;
    run(folder, "few", {500, 8}, 2);
    run(folder, "many", {5000, 8}, 2);
    const RunFile few(folder / "few"), many(folder / "many");
    for (const char* path : {"/data/480/particles/beam/position/x", "/data/240/particles/beam/momentum/z"}) {
        auto longer = many.column(path);
        longer.resize(500);
        EXPECT_EQ(few.column(path), longer);
    }
}

// Only + - * / sqrt in IEEE double, no contraction, no mathematical library: the numbers themselves are part
// of the promise "reproducible from its seed", on every machine. Whoever changes the physics changes these on
// purpose.
TEST(Run, theNumbersAreThoseOfEveryMachine) {
    const test::TempDir folder;
    run(folder, "run", {1000, 2026}, 2);
    const RunFile file(folder / "run");
    std::uint64_t hash = 14695981039346656037ull;  // FNV-1a over the values' bits
    for (const char* column :
         {"position/x", "position/y", "position/z", "momentum/x", "momentum/y", "momentum/z"}) {
        for (const double value : file.column(std::string("/data/480/particles/beam/") + column)) {
            std::uint64_t bits;
            std::memcpy(&bits, &value, sizeof bits);
            for (int i = 0; i < 8; ++i) hash = (hash ^ (bits >> (8 * i) & 0xff)) * 1099511628211ull;
        }
    }
    EXPECT_EQ(hash, 8685858601458983628ull);
}

class WrittenRun : public testing::Test {
  protected:
    static constexpr std::uint64_t particles = 3000;

    void SetUp() override {
        ASSERT_TRUE(synthesizeBeam(runJob(particles, 10), folder_ / "run.h5", progress_).ok());
        file_ = std::make_unique<RunFile>(folder_ / "run.h5");
        ASSERT_TRUE(file_->ok());
    }

    const RunFile& file() const { return *file_; }

    test::TempDir folder_;
    RecordingProgress progress_;
    std::unique_ptr<RunFile> file_;
};

TEST_F(WrittenRun, hasTheRootOfOpenPmd11) {
    EXPECT_EQ(file().text("/", "openPMD"), "1.1.0");
    EXPECT_EQ(file().number("/", "openPMDextension"), 0.0);
    EXPECT_EQ(file().text("/", "basePath"), "/data/%T/");
    EXPECT_EQ(file().text("/", "particlesPath"), "particles/");
    EXPECT_EQ(file().text("/", "iterationEncoding"), "groupBased");
    EXPECT_EQ(file().text("/", "iterationFormat"), "/data/%T/");
    EXPECT_EQ(file().number("/", "seed"), 1.0);
    EXPECT_EQ(file().text("/", "date"), "") << "a time stamp would change the bytes";
}

TEST_F(WrittenRun, hasTenIterationsWithTheirTimes) {
    EXPECT_EQ(file().children("/data").size(), 10u);
    const double speed = kinematics({}).beta * speedOfLight;
    for (const char* slice : {"0", "53", "426", "480"}) {
        const std::string path = std::string("/data/") + slice;
        ASSERT_TRUE(file().has(path));
        EXPECT_EQ(file().number(path, "timeUnitSI"), 1.0);
        EXPECT_NEAR(file().number(path, "time"), std::stod(slice) * file().number(path, "dt"), 1e-18);
        EXPECT_NEAR(file().number(path, "time") * speed, file().number(path, "place"), 1e-9);
    }
    EXPECT_NEAR(file().number("/data/480", "place"), 0.42 * channelPeriods, 1e-9);
}

TEST_F(WrittenRun, everyRecordHasItsUnitsAndDimensions) {
    const std::string beam = "/data/266/particles/beam/";
    using Powers = std::vector<double>;
    EXPECT_EQ(file().numbers(beam + "position", "unitDimension"), (Powers{1, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(file().numbers(beam + "momentum", "unitDimension"), (Powers{1, 1, -1, 0, 0, 0, 0}));
    EXPECT_EQ(file().numbers(beam + "charge", "unitDimension"), (Powers{0, 0, 1, 1, 0, 0, 0}));
    EXPECT_EQ(file().numbers(beam + "mass", "unitDimension"), (Powers{0, 1, 0, 0, 0, 0, 0}));
    for (const char* record :
         {"position", "positionOffset", "momentum", "weighting", "mass", "charge", "id"}) {
        EXPECT_EQ(file().numbers(beam + record, "unitDimension").size(), 7u) << record;
        EXPECT_EQ(file().number(beam + record, "timeOffset"), 0.0) << record;
        EXPECT_FALSE(std::isnan(file().number(beam + record, "macroWeighted"))) << record;
        EXPECT_FALSE(std::isnan(file().number(beam + record, "weightingPower"))) << record;
    }
    for (const char* component :
         {"position/x", "momentum/z", "positionOffset/y", "weighting", "mass", "charge", "id"}) {
        EXPECT_GT(file().number(beam + component, "unitSI"), 0.0) << component;
    }
    for (const char* constant :
         {"positionOffset/x", "positionOffset/y", "positionOffset/z", "weighting", "mass", "charge"}) {
        EXPECT_FALSE(file().isDataset(beam + constant)) << constant;
        EXPECT_EQ(file().numbers(beam + constant, "shape"), (Powers{particles})) << constant;
    }
    EXPECT_NEAR(file().number(beam + "mass", "value"), 1.67262192369e-27, 1e-36);
    EXPECT_EQ(file().number(beam + "charge", "value"), elementaryCharge);
    EXPECT_NEAR(file().number(beam + "weighting", "value") * particles, kinematics({}).particlesPerBunch,
                1.0);
}

TEST_F(WrittenRun, holdsTheBeamInSiUnits) {
    const std::string beam = "/data/0/particles/beam/";
    std::vector<std::uint64_t> expected(particles);
    std::iota(expected.begin(), expected.end(), 0u);
    EXPECT_EQ(file().ids(beam + "id"), expected);

    const auto pz = file().column(beam + "momentum/z");
    const double unit = file().number(beam + "momentum/z", "unitSI");
    const double mean = std::accumulate(pz.begin(), pz.end(), 0.0) / particles;
    // p = gamma m v in SI; the mean of 3000 deviations of 0.13% is good to 0.003%.
    const BeamKinematics k = kinematics({});
    const double momentum = k.gamma * 1.67262192369e-27 * k.beta * speedOfLight;
    EXPECT_NEAR(mean * unit / momentum, 1.0, 2e-4);

    // Slopes are of the order emittance / size; both come back from the file in one unit.
    const auto px = file().column(beam + "momentum/x"), x = file().column(beam + "position/x");
    double xx = 0.0, pp = 0.0;
    for (std::size_t i = 0; i < particles; ++i)
        xx += x[i] * x[i] / particles, pp += px[i] * px[i] / particles;
    // Normalised rms emittance = sqrt(<x^2> <px^2>) / mc where x and px are not correlated, as here at a
    // waist.
    EXPECT_NEAR(std::sqrt(xx * pp) / protonMassEv, 0.25e-6, 0.02e-6);
}

TEST_F(WrittenRun, deviationsOfTheMomentumAlongAreNotRounded) {
    // zeta' has to survive beside a momentum 700 times its spread: no two particles share a value.
    auto pz = file().column("/data/480/particles/beam/momentum/z");
    std::sort(pz.begin(), pz.end());
    EXPECT_TRUE(std::adjacent_find(pz.begin(), pz.end()) == pz.end());
}

TEST_F(WrittenRun, progressRisesToOne) {
    const auto& fractions = progress_.fractions();
    ASSERT_GE(fractions.size(), 10u);
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    EXPECT_EQ(fractions.back(), 1.0);
    EXPECT_FALSE(progress_.lastPhase().empty());
}

TEST(Run, aSingleStepIsTheEndOfTheChannel) {
    const test::TempDir folder;
    RecordingProgress progress;
    ASSERT_TRUE(synthesizeBeam(runJob(10, 1), folder / "run.h5", progress).ok());
    EXPECT_EQ(RunFile(folder / "run.h5").children("/data"), std::vector<std::string>{"480"});
}

TEST(Run, aSingleParticleWillDo) {
    const test::TempDir folder;
    RecordingProgress progress;
    ASSERT_TRUE(synthesizeBeam(runJob(1, 2), folder / "run.h5", progress).ok());
    EXPECT_EQ(RunFile(folder / "run.h5").column("/data/480/particles/beam/position/x").size(), 1u);
}

}  // namespace
}  // namespace mote::prep
