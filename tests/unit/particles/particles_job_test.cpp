// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/particles_job.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <set>

#include "preprocess/particles/cell_plan.h"
#include "protocol/base/json.h"
#include "storage/manifest.h"
#include "storage/particles/particle_step.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/account.h"
#include "tests/unit/particles/job_run.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;
using test::beamStep;
using test::contentOf;
using test::entriesOf;
using test::FakeSource;
using test::FakeStep;
using test::FileSizeLimit;
using test::make;
using test::requestFor;
using testing::HasSubstr;

constexpr double notANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(ParticlesJob, EveryParticleIsInOneLeafAtItsPlace) {
    const test::TempDir dir;
    FakeSource source({beamStep(20000, 1), beamStep(10000, 2, 3.0)});
    auto request = requestFor();
    request.mutable_particles()->set_volume_level(5);
    ASSERT_TRUE(make(request, source, dir / "a.mote").ok());
    test::expectAccounted(dir / "a.mote", request.particles(), source);
    EXPECT_TRUE(storage::verifyDataset(dir / "a.mote").empty());
}

TEST(ParticlesJob, DeepSmallLeavesAndAVolumeFinerThanTheOctree) {
    const test::TempDir dir;
    FakeSource source({beamStep(5000, 3)});
    auto request = requestFor("r", "theta", "delta");
    request.mutable_particles()->set_leaf_capacity(1);
    request.mutable_particles()->set_max_level(16);
    ASSERT_TRUE(make(request, source, dir / "deep.mote").ok());
    test::expectAccounted(dir / "deep.mote", request.particles(), source);
    request.mutable_particles()->set_max_level(2);
    request.mutable_particles()->set_volume_level(7);
    ASSERT_TRUE(make(request, source, dir / "flat.mote").ok());
    test::expectAccounted(dir / "flat.mote", request.particles(), source);
}

TEST(ParticlesJob, SameBytesForAnyNumberOfThreads) {
    const test::TempDir dir;
    std::map<std::string, std::string> first;
    for (const int threads : {1, 2, 3}) {
        // Enough that every parallel loop has several pieces.
        FakeSource source({beamStep(300000, 1), beamStep(1000, 2)});
        const auto output = dir / ("t" + std::to_string(threads) + ".mote");
        ASSERT_TRUE(make(requestFor(), source, output, {threads, 0}).ok());
        const auto content = contentOf(output);
        EXPECT_EQ(content.size(),
                  10U);  // manifest and digest; of each step points, columns and their digests
        if (first.empty()) first = content;
        EXPECT_TRUE(content == first) << threads;
    }
}

/// Of a single step that fits the memory, rows and then ids are held, and hashed there and not from the disk.
TEST(ParticlesJob, HashesOfWhatIsHeldAreThoseOfTheFile) {
    const test::TempDir dir;
    constexpr std::uint64_t particles = 300000;
    for (const std::uint64_t memory : {std::uint64_t{0}, std::uint64_t{160'000'000}}) {
        auto step = beamStep(particles, 1);
        // Floats alone: ids go with the last of them.
        step[Column::weight].clear();
        for (std::uint64_t i = 0; i < particles; ++i) step.ids.push_back(7 + (i * 7919 + 5) % particles);
        FakeSource source({step});
        const auto output = dir / fmt::format("of{}.mote", memory);
        const auto made = make(requestFor(), source, output, {2, memory});
        ASSERT_TRUE(made.ok()) << made.error().toString();
        EXPECT_EQ(made->particles().steps(0).particles(), particles);
        for (const auto& error : storage::verifyDataset(output)) ADD_FAILURE() << error.toString();
    }
}

TEST(ParticlesJob, LeftOutParticlesAreCountedByWhatIsWrong) {
    const test::TempDir dir;
    auto step = beamStep(1000, 1);
    step.lost.assign(1000, 0);
    step.lost[3] = 1;
    step[Column::x][3] = notANumber;  // lost comes first
    step[Column::px][4] = infinity;
    step[Column::weight][5] = notANumber;
    step[Column::weight][6] = -1.0;
    step[Column::y][7] = 1e30;
    step[Column::y][8] = -1e30;
    step[Column::z][9] = notANumber;  // no axis of this plot
    FakeSource source({step});
    test::QuietProgress progress;
    const auto request = requestFor();
    const auto manifest = runParticlesJob(request, source, {dir / "fake.h5"}, dir / "a.mote", {}, progress);
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    const auto& entry = manifest->particles().steps(0);
    EXPECT_EQ(entry.lost(), 1U);
    EXPECT_EQ(entry.invalid(), 3U);
    EXPECT_EQ(entry.outside(), 2U);
    EXPECT_EQ(entry.particles(), 994U);
    EXPECT_LT(manifest->particles().axes(2).max(), 1.0);
    EXPECT_THAT(progress.notes, testing::Contains(HasSubstr("2 particles")));
    EXPECT_TRUE(std::is_sorted(progress.fractions.begin(), progress.fractions.end()));
    EXPECT_EQ(progress.fractions.back(), 1.0);
    test::expectAccounted(dir / "a.mote", request.particles(), source);
}

TEST(ParticlesJob, AnAcceleratedBunchStaysAndWhatIsCutIsSaid) {
    const test::TempDir dir;
    auto step = beamStep(5000, 1);
    for (std::size_t i = 0; i < 100; ++i) step[Column::px][50 * i] = 1e7 + static_cast<double>(i);
    FakeSource source({step});
    const auto whole = make(requestFor(), source, dir / "whole.mote");
    ASSERT_TRUE(whole.ok()) << whole.error().toString();
    EXPECT_EQ(whole->particles().steps(0).outside(), 0U);
    EXPECT_EQ(whole->particles().notes_size(), 0);
    step[Column::px][7] = 1e30;
    FakeSource strange({step});
    const auto cut = make(requestFor(), strange, dir / "cut.mote");
    ASSERT_TRUE(cut.ok()) << cut.error().toString();
    EXPECT_EQ(cut->particles().steps(0).outside(), 1U);
    EXPECT_EQ(cut->particles().axes(1).max(), 1e7 + 99);
    EXPECT_THAT(cut->particles().notes(), testing::Contains(HasSubstr("--bounds px=")));
    EXPECT_TRUE(storage::verifyDataset(dir / "cut.mote").empty());
}

TEST(ParticlesJob, GivenBoundsHoldAndTheRestIsOutside) {
    const test::TempDir dir;
    FakeSource source({beamStep(5000, 1)});
    auto request = requestFor();
    auto& bounds = *request.mutable_particles()->add_bounds();
    bounds.set_name("px");
    bounds.set_min(-1e-3);
    bounds.set_max(5e-4);
    const auto manifest = make(request, source, dir / "a.mote");
    ASSERT_TRUE(manifest.ok());
    EXPECT_EQ(manifest->particles().axes(1).min(), -1e-3);
    EXPECT_EQ(manifest->particles().axes(1).max(), 5e-4);
    EXPECT_GT(manifest->particles().steps(0).outside(), 100U);
    test::expectAccounted(dir / "a.mote", request.particles(), source);
}

TEST(ParticlesJob, BoundsAreThoseOfTheWholeSeries) {
    const test::TempDir dir;
    FakeSource source({beamStep(500, 1), beamStep(500, 2, 20.0), beamStep(500, 3)});
    auto request = requestFor();
    request.mutable_particles()->set_steps("0:2:2");
    const auto two = make(request, source, dir / "two.mote");
    const auto three = make(requestFor(), source, dir / "three.mote");
    ASSERT_TRUE(two.ok() && three.ok());
    EXPECT_EQ(two->particles().steps_size(), 2);
    EXPECT_LT(two->particles().axes(0).max() * 5.0, three->particles().axes(0).max());
}

TEST(ParticlesJob, ABeamThatTravelsThroughItsPlotIsSaid) {
    const test::TempDir dir;
    const auto notesOf = [&](double distance, const std::string& boundsOf) {
        std::vector<FakeStep> steps;
        for (int i = 0; i < 10; ++i) {
            steps.push_back(beamStep(500, 1));
            const auto [least, most] = std::ranges::minmax(steps.back()[Column::x]);
            for (auto& x : steps.back()[Column::x]) x += distance * (most - least) * i;
        }
        FakeSource source(steps);
        auto request = requestFor();
        request.mutable_particles()->set_bounds_of(boundsOf);
        const auto manifest = make(request, source, dir / fmt::format("{}{}.mote", distance, boundsOf));
        EXPECT_TRUE(manifest.ok());
        return std::vector<std::string>(manifest->particles().notes().begin(),
                                        manifest->particles().notes().end());
    };
    EXPECT_THAT(notesOf(0.8, ""),
                testing::ElementsAre("over all steps x spans more than 8 times what it spans in "
                                     "any one of them, so the beam is small in this plot; "
                                     "--bounds-of step follows it, and so does the axis x_c"));
    EXPECT_THAT(notesOf(0.8, "step"), testing::IsEmpty());
    EXPECT_THAT(notesOf(0.7, ""), testing::IsEmpty());  // 7.3 times
}

TEST(ParticlesJob, NoOneOrTheSameParticle) {
    const test::TempDir dir;
    FakeStep one;
    one[Column::x] = {0.5};
    one[Column::y] = {-2.0};
    one[Column::px] = {0.0};
    FakeStep none;
    FakeStep allLost = one;
    allLost.lost = {1};
    FakeStep duplicates;
    for (const auto column : {Column::x, Column::y, Column::px}) duplicates[column].assign(100000, 0.5);
    FakeSource source({one, none, allLost, duplicates});
    const auto request = requestFor();
    const auto manifest = make(request, source, dir / "a.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    test::expectAccounted(dir / "a.mote", request.particles(), source);
    EXPECT_TRUE(storage::verifyDataset(dir / "a.mote").empty());
    for (const std::uint32_t step : {1U, 2U}) {
        const auto empty = *storage::ParticleStep::open(dir / "a.mote", *manifest, step);
        EXPECT_EQ(empty->pointCount(), 0U);
        EXPECT_EQ(empty->nodes().size(), 1U);
        EXPECT_EQ(empty->nodes().count[0], 0U);
        ASSERT_EQ(empty->leaves().size(), 1U);
        EXPECT_EQ(empty->leaves().pointCount[0], 0U);
        EXPECT_TRUE(empty->positions(0, 0).empty());
        EXPECT_EQ(empty->volume()[0], 0.0F);
    }
    // A single value lies in the middle of its axis.
    FakeSource single({one});
    ASSERT_TRUE(make(request, single, dir / "one.mote").ok());
    const auto opened =
        *storage::ParticleStep::open(dir / "one.mote", *storage::readManifest(dir / "one.mote"), 0);
    const auto position = opened->positions(0, 1)[0];
    EXPECT_NEAR(position.x, 32768, 1);
    EXPECT_NEAR(position.y, 32768, 1);
    EXPECT_NEAR(position.z, 32768, 1);
}

TEST(ParticlesJob, NothingToPlotIsOneClearError) {
    const test::TempDir dir;
    FakeStep none;
    auto lost = beamStep(10, 1);
    lost.lost.assign(10, 1);
    auto invalid = beamStep(10, 1);
    invalid[Column::x].assign(10, notANumber);
    for (const auto& step : {none, lost, invalid}) {
        FakeSource source({step});
        const auto made = make(requestFor(), source, dir / "a.mote");
        ASSERT_FALSE(made.ok());
        EXPECT_THAT(made.error().toString(), HasSubstr("no selected step has a particle"));
    }
    auto weightless = beamStep(10, 1);
    weightless[Column::weight].assign(10, 0.0);
    FakeSource source({weightless});
    EXPECT_THAT(make(requestFor(), source, dir / "a.mote").error().message, HasSubstr("weigh nothing"));
    EXPECT_EQ(entriesOf(dir.path()), 0U);
}

TEST(ParticlesJob, SomeWeightlessParticlesAreTheThinnest) {
    const test::TempDir dir;
    auto step = beamStep(2000, 1);
    for (std::size_t i = 0; i < 2000; i += 2) step[Column::weight][i] = 0.0;
    FakeSource source({step});
    auto request = requestFor();
    request.mutable_particles()->set_leaf_capacity(1);
    const auto manifest = make(request, source, dir / "a.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    EXPECT_GT(manifest->particles().density_min(), 0.0);
    test::expectAccounted(dir / "a.mote", request.particles(), source);
}

TEST(ParticlesJob, AnAxisThatTheRunDoesNotHave) {
    const test::TempDir dir;
    FakeSource source({beamStep(10, 1)});
    EXPECT_EQ(make(requestFor("x", "y", "energy"), source, dir / "a.mote").error().where, "axis energy");
    EXPECT_EQ(make(requestFor("x", "y", "t"), source, dir / "a.mote").error().code, ErrorCode::notFound);
    EXPECT_EQ(entriesOf(dir.path()), 0U);
}

TEST(ParticlesJob, AnOutputThatIsThereIsLeftAlone) {
    const test::TempDir dir;
    FakeSource source({beamStep(10, 1)});
    fs::create_directory(dir / "a.mote");
    std::ofstream(dir / "a.mote" / "mine") << "mine";
    EXPECT_EQ(make(requestFor(), source, dir / "a.mote").error().code, ErrorCode::alreadyExists);
    EXPECT_TRUE(fs::exists(dir / "a.mote" / "mine"));
    EXPECT_EQ(entriesOf(dir.path()), 1U);
    EXPECT_EQ(make(requestFor(), source, dir / "nowhere" / "a.mote").error().code, ErrorCode::notFound);
    EXPECT_EQ(make(requestFor(), source, dir / "a.h5").error().code, ErrorCode::invalidArgument);
}

/// Somebody who may not write the test's folder, for as long as the object lives; root may write everywhere.
class Stranger {
  public:
    explicit Stranger(const fs::path& folder) : folder_(folder) {
        fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read |
                                    fs::perms::others_exec);
        constexpr uid_t nobody = 65534;
        if (root_ && ::seteuid(nobody) != 0) ADD_FAILURE() << "root cannot become somebody else";
    }
    ~Stranger() {
        if (root_ && ::seteuid(0) != 0) ADD_FAILURE() << "somebody else cannot become root";
        fs::permissions(folder_, fs::perms::owner_all);
    }

  private:
    fs::path folder_;
    bool root_ = ::geteuid() == 0;
};

TEST(ParticlesJob, AnOutputThatCannotBeWritten) {
    const test::TempDir dir;
    FakeSource source({beamStep(10, 1)});
    {
        const Stranger stranger(dir.path());
        const auto made = make(requestFor(), source, dir / "a.mote");
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::permissionDenied) << made.error().toString();
    }
    EXPECT_EQ(entriesOf(dir.path()), 0U);
}

TEST(ParticlesJob, AFullDiskIsOneErrorAndNoDebris) {
    const test::TempDir dir;
    // In the middle of the step's file; just below its end; only the manifest fails.
    for (const rlim_t bytes : {1000UL, 40000UL, 1400000UL}) {
        FakeSource source({beamStep(20000, 1)});
        const FileSizeLimit limit(bytes);
        const auto made = make(requestFor(), source, dir / "a.mote");
        ASSERT_FALSE(made.ok()) << bytes;
        EXPECT_EQ(made.error().code, ErrorCode::resourceExhausted) << made.error().toString();
        EXPECT_EQ(entriesOf(dir.path()), 0U);
    }
    FakeSource source({beamStep(20000, 1)});
    EXPECT_TRUE(make(requestFor(), source, dir / "a.mote").ok());
}

TEST(ParticlesJob, MemoryIsBoundedByAClearError) {
    const test::TempDir dir;
    FakeSource source({beamStep(20000, 1)});
    const auto made = make(requestFor(), source, dir / "a.mote", {0, 1 << 20});
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(made.error().toString(), HasSubstr("20000 particles"));
    EXPECT_TRUE(make(requestFor(), source, dir / "a.mote", {0, 1 << 28}).ok());
}

TEST(ParticlesJob, CancelledAnywhereLeavesNoDebris) {
    const test::TempDir dir;
    const auto request = requestFor();
    const auto run = [&](long after) {
        FakeSource source({beamStep(2000, 1), beamStep(2000, 2)});
        test::QuietProgress progress(after);
        const auto made = runParticlesJob(request, source, {dir / "fake.h5"}, dir / "a.mote", {}, progress);
        if (!made.ok()) {
            EXPECT_EQ(made.error().code, ErrorCode::cancelled);
            EXPECT_EQ(entriesOf(dir.path()), 0U);
        }
        return made.ok();
    };
    long after = 0;
    while (!run(after)) ++after;
    EXPECT_GT(after, 10);  // it asked that often, and stopped each time
}

TEST(ParticlesJob, TheManifestSaysHowToMakeItAgain) {
    const test::TempDir dir;
    fs::create_directories(dir / "plots");
    FakeSource source({beamStep(100, 1)});
    auto request = requestFor();
    request.set_output("data/plots/a.mote");
    request.set_title("A title");
    test::QuietProgress progress;
    ASSERT_TRUE(
        runParticlesJob(request, source, {dir / "runs" / "fake.h5"}, dir / "plots" / "a.mote", {}, progress)
            .ok());
    const auto manifest = storage::readManifest(dir / "plots" / "a.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    EXPECT_EQ(manifest->title(), "A title");
    EXPECT_EQ(manifest->request().output(), "");
    EXPECT_EQ(manifest->request().particles().inputs(0), "../runs/fake.h5");
    EXPECT_THAT(manifest->request().particles().axes(), testing::ElementsAre("x", "px", "y"));
}

TEST(ParticlesJob, EveryPrefixOfALeafIsAFairSample) {
    const test::TempDir dir;
    // One leaf of 4000 particles in the order of x: the first half of its points must not lean to one side.
    FakeStep step;
    for (int i = 0; i < 4000; ++i) {
        for (const auto column : {Column::x, Column::px, Column::y}) step[column].push_back(i);
    }
    FakeSource source({step});
    auto request = requestFor();
    request.mutable_particles()->set_leaf_capacity(4000);
    ASSERT_TRUE(make(request, source, dir / "a.mote").ok());
    const auto opened =
        *storage::ParticleStep::open(dir / "a.mote", *storage::readManifest(dir / "a.mote"), 0);
    ASSERT_EQ(opened->leaves().size(), 1U);
    const auto rows = opened->rows(0, 4000);
    for (const std::size_t prefix : {100UL, 1000UL, 2000UL}) {
        double mean = 0.0;
        for (std::size_t i = 0; i < prefix; ++i)
            mean += static_cast<double>(rows[i]) / static_cast<double>(prefix);
        // The mean of n rows drawn without replacement from 0 to 3999 has a standard deviation below
        // 4000 / sqrt(12 n); five of them.
        EXPECT_NEAR(mean, 1999.5, 5.0 * 4000.0 / std::sqrt(12.0 * static_cast<double>(prefix)));
    }
    EXPECT_EQ(std::set<std::uint64_t>(rows.begin(), rows.end()).size(), 4000U);
}

}  // namespace
}  // namespace mote::prep
