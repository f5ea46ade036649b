// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whole runs: what the file says, and that a seed gives the same bytes whatever the chunks and threads.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <numeric>

#include "preprocess/synth/beam_run.h"
#include "preprocess/synth/openpmd_writer.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"
#include "tests/unit/synth/run_file.h"

namespace mote::prep {
namespace {

using test::QuietProgress;
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
    QuietProgress progress;
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
    QuietProgress progress_;
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
    const auto& fractions = progress_.fractions;
    ASSERT_GE(fractions.size(), 10u);
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    EXPECT_EQ(fractions.back(), 1.0);
    EXPECT_FALSE(progress_.phases.back().empty());
}

TEST(Run, aSingleStepIsTheEndOfTheChannel) {
    const test::TempDir folder;
    QuietProgress progress;
    ASSERT_TRUE(synthesizeBeam(runJob(10, 1), folder / "run.h5", progress).ok());
    EXPECT_EQ(RunFile(folder / "run.h5").children("/data"), std::vector<std::string>{"480"});
}

TEST(Run, aSingleParticleWillDo) {
    const test::TempDir folder;
    QuietProgress progress;
    ASSERT_TRUE(synthesizeBeam(runJob(1, 2), folder / "run.h5", progress).ok());
    EXPECT_EQ(RunFile(folder / "run.h5").column("/data/480/particles/beam/position/x").size(), 1u);
}

// What goes wrong: bad requests, outputs that exist or cannot be, cancelling, full disks. No debris in any
// case.

namespace fs = std::filesystem;

proto::SynthBeamJob job(std::uint64_t particles, std::uint32_t steps) {
    proto::SynthBeamJob result;
    result.set_particles(particles);
    result.set_steps(steps);
    return result;
}

ErrorCode codeOf(const Status& status) {
    EXPECT_FALSE(status.ok());
    return status.ok() ? ErrorCode::internal : status.error().code;
}

std::size_t openFiles() {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

/// The kernel refuses files longer than `bytes` while this lives, as on a full disk.
class SmallDisk {
  public:
    explicit SmallDisk(rlim_t bytes) {
        getrlimit(RLIMIT_FSIZE, &before_);
        handler_ = signal(SIGXFSZ, SIG_IGN);
        const rlimit small{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &small);
    }
    ~SmallDisk() {
        setrlimit(RLIMIT_FSIZE, &before_);
        signal(SIGXFSZ, handler_);
    }

  private:
    rlimit before_{};
    void (*handler_)(int) = nullptr;
};

TEST(Output, badRequestsNameTheirField) {
    const test::TempDir folder;
    QuietProgress progress;
    const auto refused = [&](const proto::SynthBeamJob& request, const char* field) {
        const Status status = synthesizeBeam(request, folder / "run.h5", progress);
        EXPECT_EQ(codeOf(status), ErrorCode::invalidArgument);
        EXPECT_EQ(status.error().where, field);
    };
    refused(job(0, 1), "synthBeam.particles");
    refused(job(std::numeric_limits<std::uint64_t>::max(), 1), "synthBeam.particles");
    refused(job(1, 0), "synthBeam.steps");
    refused(job(1, 10'001), "synthBeam.steps");
    for (const double mismatch : {0.0, 0.4, 3.0, -1.5, std::numeric_limits<double>::quiet_NaN()}) {
        auto request = job(1, 1);
        request.set_mismatch(mismatch);
        refused(request, "synthBeam.mismatch");
    }
    EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Output, everyMismatchAllowedRuns) {
    for (const double mismatch : {0.5, 0.75, 1.0, 1.25, 2.0, 2.5}) {
        const auto plan = planChannel(mismatched({}, mismatch), 10);
        EXPECT_TRUE(plan.ok()) << mismatch;
    }
}

TEST(Output, anExistingFileIsRefusedAndKept) {
    const test::TempDir folder;
    std::ofstream(folder / "run.h5") << "mine";
    QuietProgress progress;
    EXPECT_EQ(codeOf(synthesizeBeam(job(10, 1), folder / "run.h5", progress)), ErrorCode::alreadyExists);
    EXPECT_EQ(fs::file_size(folder / "run.h5"), 4u);
    fs::create_symlink("nowhere", folder / "link.h5");
    EXPECT_EQ(codeOf(synthesizeBeam(job(10, 1), folder / "link.h5", progress)), ErrorCode::alreadyExists);
}

TEST(Output, aMissingFolderIsNotMade) {
    const test::TempDir folder;
    QuietProgress progress;
    EXPECT_EQ(codeOf(synthesizeBeam(job(10, 1), folder / "none" / "run.h5", progress)), ErrorCode::notFound);
    EXPECT_FALSE(fs::exists(folder / "none"));
}

TEST(Output, aCancelledRunLeavesNothing) {
    const test::TempDir folder;
    const std::size_t before = openFiles();
    for (const int questions : {0, 1, 5}) {
        QuietProgress progress(questions);
        EXPECT_EQ(codeOf(synthesizeBeam(job(20'000, 4), folder / "run.h5", progress)), ErrorCode::cancelled);
        EXPECT_TRUE(fs::is_empty(folder.path()));
        EXPECT_LT(progress.fractions.back(), 1.0);
    }
    EXPECT_EQ(openFiles(), before);
}

TEST(Output, aFullDiskIsSeenBeforeTheWork) {
    const test::TempDir folder;
    const std::size_t before = openFiles();
    QuietProgress progress;
    const SmallDisk disk(200'000);  // room for the structure, not for 44 bytes times 100 000
    const Status status = synthesizeBeam(job(100'000, 2), folder / "run.h5", progress);
    EXPECT_EQ(codeOf(status), ErrorCode::resourceExhausted) << status.error().toString();
    EXPECT_EQ(progress.fractions.back(), 0.0);
    EXPECT_TRUE(fs::is_empty(folder.path()));
    EXPECT_EQ(openFiles(), before);
}

// A file system that reserves nothing shows it only while writing: the writer alone, without the reservation.
// HDF5 1.10 crashes at the end of the process where the close of a file failed; this process has to end well
// after this.
TEST(Output, aDiskThatFillsWhileWritingIsResourceExhausted) {
    const test::TempDir folder;
    const std::size_t before = openFiles();
    const auto plan = planChannel(mismatched({}, 1.5), 2).value();
    {
        auto writer = OpenPmdWriter::create(folder / "run.h5");
        ASSERT_TRUE(writer.ok());
        ASSERT_TRUE(writer->layOut(plan, 100'000, 1).ok());
        const SmallDisk disk(200'000);
        EXPECT_EQ(codeOf(writer->write(1, 0, 100'000, BeamColumns(100'000))), ErrorCode::resourceExhausted);
    }
    EXPECT_EQ(openFiles(), before);
}

TEST(Output, theReservationIsTheFilesSize) {
    const test::TempDir folder;
    QuietProgress progress;
    for (const std::uint32_t steps : {1u, 10u, 100u}) {
        const auto path = folder / std::to_string(steps);
        ASSERT_TRUE(synthesizeBeam(job(100, steps), path, progress).ok());
        const auto plan = planChannel(mismatched({}, 1.5), steps).value();
        const auto size = static_cast<double>(fs::file_size(path));
        EXPECT_NEAR(static_cast<double>(OpenPmdWriter::fileBytes(plan, 100)) / size, 1.0, 0.1) << size;
        EXPECT_GE(OpenPmdWriter::fileBytes(plan, 100), fs::file_size(path));
    }
}

TEST(Output, aWildMismatchIsNoted) {
    const test::TempDir folder;
    QuietProgress progress;
    ASSERT_TRUE(synthesizeBeam(job(10, 1), folder / "default.h5", progress).ok());
    EXPECT_TRUE(progress.notes.empty());
    auto wild = job(10, 1);
    wild.set_mismatch(2.5);
    ASSERT_TRUE(synthesizeBeam(wild, folder / "wild.h5", progress).ok());
    EXPECT_EQ(progress.notes.size(), 1u);
}

}  // namespace
}  // namespace mote::prep
