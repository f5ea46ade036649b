// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/volume_job.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/normal_table.h"
#include "storage/manifest.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/volume_job_run.h"

namespace mote::prep {
namespace {

using storage::GridSize;
using test::eachSample;
using test::expectWithin;
using test::jobOf;
using test::make;
using test::makeVolume;
using test::Reconstruction;
using test::sample;
using test::slack;
using test::Volume;

TEST(VolumeJob, AResidualOfThresholdZeroIsTheSourceToItsQuantum) {
    for (const auto type : {ScalarType::u8, ScalarType::i16}) {
        const test::TempDir dir;
        const auto volume = sample(45, 38, 41, type);
        make({volume}, jobOf(0.0, 12, "residual"), dir / "a.mote");
        const Reconstruction made(dir / "a.mote", 0);
        EXPECT_EQ(made.entry().residual_step(), 1.0);
        expectWithin(volume, made, 0.5);
    }
}

TEST(VolumeJob, AResidualOfThresholdZeroOfFloats) {
    const test::TempDir dir;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1e-3, 2e-3);
    const auto volume =
        makeVolume(20, 30, 17, ScalarType::f32, [&](int, int, int) { return uniform(random); });
    make({volume}, jobOf(0.0, 8, "residual"), dir / "a.mote");
    const Reconstruction made(dir / "a.mote", 0);
    EXPECT_LE(made.entry().residual_step(), 3e-3 / 65536);
    expectWithin(volume, made, made.entry().residual_step() / 2);
}

/// 8-bit numbers with a slope: a step of a sixteenth, the power of two below it, tells them all apart.
TEST(VolumeJob, AResidualOfThresholdZeroOfNumbersWithASlope) {
    const test::TempDir dir;
    auto volume = sample(45, 38, 41);
    for (auto& value : volume.values) value = 0.1F * value - 3.0F;
    volume.shape.valueStep = 0.1;
    make({volume}, jobOf(0.0, 12, "residual"), dir / "a.mote");
    const Reconstruction made(dir / "a.mote", 0);
    EXPECT_EQ(made.entry().residual_step(), 1.0 / 16);
    expectWithin(volume, made, 1.0 / 32);
}

/// Their span is too wide for a step of 1.
TEST(VolumeJob, AResidualOfThresholdZeroOfWideIntegers) {
    const test::TempDir dir;
    std::mt19937 random(5);
    const auto volume = makeVolume(20, 30, 17, ScalarType::i32, [&](int, int, int) {
        return std::floor(static_cast<double>(random()) - 2147483648.0);
    });
    make({volume}, jobOf(0.0, 8, "both"), dir / "a.mote");
    const Reconstruction made(dir / "a.mote", 0);
    expectWithin(volume, made, made.entry().residual_step() / 2);
    EXPECT_LE(made.entry().residual_step(), 4294967296.0 / (1 << 19));
}

TEST(VolumeJob, NoErrorIsLeftAboveTheThreshold) {
    for (const auto* filter : {"cubic", "box", "under:0.1"}) {
        for (const double threshold : {0.02, 0.11}) {
            const test::TempDir dir;
            const auto volume = sample(45, 38, 41);
            auto job = jobOf(threshold, 12, "residual");
            job.set_filter(filter);
            make({volume}, job, dir / "a.mote");
            const Reconstruction made(dir / "a.mote", 0);
            expectWithin(volume, made, made.entry().threshold());
            // Where the error is at the threshold or below, nothing is stored.
            const double little = made.entry().threshold() - slack(volume);
            const GridSize grid{45, 38, 41};
            eachSample(grid, [&](const GridSize& at) {
                const double error = volume.at(at[0], at[1], at[2]) - made.low(at, grid);
                const bool small = std::abs(error) < little;
                EXPECT_TRUE(!small || made.residual(at) == 0.0);
            });
        }
    }
}

TEST(VolumeJob, PointsLieWhereTheErrorIsAboveTheThreshold) {
    for (const std::uint32_t bytes : {5U, 6U, 9U}) {
        const test::TempDir dir;
        const auto volume = sample(70, 38, 41);
        auto job = jobOf(0.05, 20, "points");
        job.set_point_bytes(bytes);
        make({volume}, job, dir / "a.mote");
        const Reconstruction made(dir / "a.mote", 0);
        const GridSize grid{70, 38, 41};
        std::map<GridSize, storage::HybridPoint> points;
        for (const auto& point : made.points()) points[point.place] = point;
        ASSERT_EQ(points.size(), made.entry().points());
        const auto& hybrid = made.manifest().hybrid();
        const double rounding = slack(volume);
        eachSample(grid, [&](const GridSize& at) {
            const double value = volume.at(at[0], at[1], at[2]);
            const double error = value - made.low(at, grid);
            const auto found = points.find(at);
            if (std::abs(std::abs(error) - made.entry().threshold()) > rounding) {
                ASSERT_EQ(found != points.end(), std::abs(error) > made.entry().threshold());
            }
            if (found == points.end()) return;
            // A code is off by half a step at most.
            EXPECT_NEAR(storage::pointError(made.entry(), found->second.error), error,
                        made.entry().error_step() / 2 + rounding);
            EXPECT_NEAR(storage::pointValue(hybrid, found->second.value), value,
                        (hybrid.value_max() - hybrid.value_min()) / 510 + rounding);
        });
    }
}

TEST(VolumeJob, TheGreatestErrorsAndNoMore) {
    for (const std::uint64_t most : {std::uint64_t{1}, std::uint64_t{777}, std::uint64_t{20000}}) {
        const test::TempDir dir;
        const auto volume = sample(45, 38, 41);
        proto::VolumeJob job;
        job.set_max_points(most);
        job.set_low(12);
        job.set_representation("points");
        make({volume}, job, dir / "a.mote");
        const Reconstruction made(dir / "a.mote", 0);
        EXPECT_EQ(made.entry().points(), most);
        const GridSize grid{45, 38, 41};
        std::map<GridSize, bool> taken;
        for (const auto& point : made.points()) taken[point.place] = true;
        double least = 1e9;
        double greatestLeft = 0.0;
        eachSample(grid, [&](const GridSize& at) {
            const double error = std::abs(volume.at(at[0], at[1], at[2]) - made.low(at, grid));
            if (taken.contains(at)) least = std::min(least, error);
            if (!taken.contains(at)) greatestLeft = std::max(greatestLeft, error);
        });
        EXPECT_GE(least, greatestLeft - slack(volume));
    }
}

/// A checkerboard has one magnitude of error, everywhere.
TEST(VolumeJob, OfEqualErrorsTheFirstAreTaken) {
    const test::TempDir dir;
    const auto volume = makeVolume(40, 40, 40, ScalarType::u8,
                                   [](unsigned x, unsigned y, unsigned z) { return 2 * ((x + y + z) % 2); });
    proto::VolumeJob job;
    job.set_max_points(1000);
    job.set_low(1);
    job.set_filter("box");
    job.set_representation("points");
    make({volume}, job, dir / "a.mote");
    const Reconstruction made(dir / "a.mote", 0);
    ASSERT_EQ(made.points().size(), 1000U);
    // No code is just between 0 and 2, so those of one colour are a little further off: half of a brick is
    // enough.
    const auto parity = [](const GridSize& at) { return (at[0] + at[1] + at[2]) % 2; };
    const auto first = made.points().front().place;
    EXPECT_TRUE(first[0] <= 1 && first[1] == 0 && first[2] == 0);
    for (const auto& point : made.points()) {
        EXPECT_TRUE(point.place[0] < 32 && point.place[1] < 32 && point.place[2] < 2);
        EXPECT_EQ(parity(point.place), parity(first));
    }
}

TEST(VolumeJob, MorePointsThanThereAreErrors) {
    const test::TempDir dir;
    const auto volume = makeVolume(9, 9, 9, ScalarType::u8, [](int x, int, int) { return x == 4 ? 1 : 0; });
    proto::VolumeJob job;
    job.set_max_points(1000);
    job.set_representation("both");
    make({volume}, job, dir / "a.mote");
    const Reconstruction made(dir / "a.mote", 0);
    EXPECT_EQ(made.entry().points(), 0U);  // the low-resolution volume is the source
    EXPECT_EQ(made.entry().residual_samples(), 0U);
}

TEST(VolumeJob, NeverOverestimatesByMoreThanTheAllowance) {
    for (const double allowance : {0.0, 0.1, 0.5}) {
        const test::TempDir dir;
        const auto volume = sample(45, 38, 41);
        auto job = jobOf(0.05, 12, "residual");
        job.set_filter(fmt::format("under:{}", allowance));
        make({volume}, job, dir / "a.mote");
        const Reconstruction made(dir / "a.mote", 0);
        const auto& hybrid = made.manifest().hybrid();
        const double most = allowance * (hybrid.value_max() - hybrid.value_min());
        const GridSize grid{45, 38, 41};
        double worst = -1e9;
        eachSample(grid, [&](const GridSize& at) {
            worst = std::max(worst, made.low(at, grid) - volume.at(at[0], at[1], at[2]));
        });
        EXPECT_LE(worst, most + slack(volume));
        // And it is lowered no further than needed anywhere: somewhere the allowance is used up, but for a
        // code's step.
        EXPECT_GE(worst, std::min(most, 20.0) - 2.0 * made.entry().value_step());
    }
}

TEST(VolumeJob, ABoxIsTheMeanOfItsSamples) {
    const test::TempDir dir;
    const auto volume = sample(16, 12, 8);
    auto job = jobOf(1.0, 4, "residual");
    job.set_filter("box");
    job.set_value_bits(16);
    make({volume}, job, dir / "a.mote");
    const Reconstruction made(dir / "a.mote", 0);
    eachSample({4, 3, 2}, [&](const GridSize& low) {
        double sum = 0.0;
        eachSample({4, 4, 4}, [&](const GridSize& at) {
            sum += volume.at(4 * low[0] + at[0], 4 * low[1] + at[1], 4 * low[2] + at[2]);
        });
        EXPECT_NEAR(made.low(low, {4, 3, 2}), sum / 64, made.entry().value_step() / 2 + slack(volume));
    });
}

/// A slope is reproduced by weights that are symmetric, as they are where four samples become one; away from
/// the ends. What is left is half a code's step, 226 / 65535 / 2, and floats' rounding.
TEST(VolumeJob, FiltersReproduceALinearVolume) {
    for (const auto* filter : {"cubic", "box"}) {
        const test::TempDir dir;
        const auto volume = makeVolume(40, 32, 24, ScalarType::f32,
                                       [](double x, double y, double z) { return 2 * x - y + 3 * z; });
        auto job = jobOf(1.0, 10, "residual");
        job.set_filter(filter);
        make({volume}, job, dir / "a.mote");
        const Reconstruction made(dir / "a.mote", 0);
        const GridSize grid{40, 32, 24};
        eachSample(grid, [&](const GridSize& at) {
            for (std::size_t a = 0; a < 3; ++a) {
                if (at[a] < 10 || at[a] + 10 >= grid[a]) return;
            }
            EXPECT_NEAR(made.low(at, grid), volume.at(at[0], at[1], at[2]), 0.005);
        });
    }
}

TEST(VolumeJob, NormalsPointDownhillInTheWorld) {
    const test::TempDir dir;
    auto volume = makeVolume(32, 32, 32, ScalarType::f32, [](double x, double y, double) { return x + y; });
    volume.shape.indexToWorld[1][1] = 3.0;  // three times as far along y, so a third of the slope
    auto job = jobOf(0.0, 16, "both");
    make({volume}, job, dir / "a.mote");
    const Reconstruction made(dir / "a.mote", 0);
    const storage::NormalTable table;
    const auto expected = table.code({-1.0F, -1.0F / 3.0F, 0.0F});
    EXPECT_EQ(made.normal({8, 8, 8}), expected);
    for (const auto& point : made.points()) EXPECT_EQ(point.normal, expected);
}

TEST(VolumeJob, CoarserErrorGridsSampleTheSourceBetween) {
    const test::TempDir dir;
    const auto volume = sample(32, 32, 32);
    auto job = jobOf(0.0, 8, "residual");
    job.set_error_grid(16);
    make({volume}, job, dir / "a.mote");
    const Reconstruction made(dir / "a.mote", 0);
    const GridSize grid{16, 16, 16};
    EXPECT_EQ(storage::gridSize(made.manifest().hybrid().error_size()), grid);
    eachSample(grid, [&](const GridSize& at) {
        double mean = 0.0;  // half way between two samples along each axis
        eachSample({2, 2, 2}, [&](const GridSize& d) {
            mean += volume.at(2 * at[0] + d[0], 2 * at[1] + d[1], 2 * at[2] + d[2]) / 8.0;
        });
        EXPECT_NEAR(made.low(at, grid) + made.residual(at), mean, 0.5 + slack(volume));
    });
}

}  // namespace
}  // namespace mote::prep
