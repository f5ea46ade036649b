// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>

#include "preprocess/hybrid/volume_job.h"
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

namespace fs = std::filesystem;
using test::QuietProgress;
using testing::HasSubstr;

/// What is found is put aside in other pieces on other threads, and where slabs are thinner.
TEST(VolumeJob, SameBytesForAnyThreadsAndMemory) {
    const test::TempDir dir;
    const auto volume = sample(70, 65, 75);
    for (const auto* filter : {"cubic", "under:0.05"}) {
        std::map<std::string, std::string> expected;
        int run = 0;
        // The last two have room for slabs of 16 and of 8 slices.
        for (const JobResources& options :
             {JobResources{1, 0}, JobResources{4, 0}, JobResources{2, 99 << 20}, JobResources{1, 97 << 20}}) {
            auto job = jobOf(0.03, 20, "both");
            job.set_filter(filter);
            if (filter[0] == 'u') job.set_max_points(20000);
            if (filter[0] == 'u') job.clear_threshold();
            const auto output = dir / fmt::format("{}-{}.mote", filter[0], run++);
            make({volume}, job, output, options);
            const auto manifest = *storage::readManifest(output);
            for (const auto& file : manifest.files()) {
                const auto [at, fresh] = expected.emplace(file.name(), file.xxh3_128());
                EXPECT_EQ(at->second, file.xxh3_128()) << file.name();
            }
            // Nothing of what was put aside is left.
            const fs::directory_iterator files(output);
            EXPECT_EQ(std::distance(begin(files), end(files)), manifest.files_size() + 2);
        }
    }
}

TEST(VolumeJob, AConstantVolume) {
    for (const auto* filter : {"cubic", "box", "under:0"}) {
        const test::TempDir dir;
        const auto volume = makeVolume(20, 9, 33, ScalarType::i16, [](int, int, int) { return -1000; });
        auto job = jobOf(0.0, 8, "both");
        job.set_filter(filter);
        make({volume}, job, dir / "a.mote");
        const Reconstruction made(dir / "a.mote", 0);
        EXPECT_EQ(made.entry().points(), 0U);
        EXPECT_EQ(made.entry().residual_samples(), 0U);
        EXPECT_EQ(made.manifest().hybrid().value_min(), -1000.0);
        expectWithin(volume, made, 0.0);
    }
}

TEST(VolumeJob, DimensionsOfOne) {
    for (const GridSize size : {GridSize{1, 1, 1}, {50, 1, 1}, {1, 40, 3}, {2, 1, 60}}) {
        const test::TempDir dir;
        const auto volume = sample(size[0], size[1], size[2]);
        make({volume}, jobOf(0.0, 8, "both"), dir / "a.mote");
        expectWithin(volume, Reconstruction(dir / "a.mote", 0), 0.5);
    }
}

TEST(VolumeJob, SaysIfSlicesAreTakenForAPatients) {
    const test::TempDir dir;
    auto volume = sample(20, 20, 20, ScalarType::f32);
    const auto notesOf = [&](const char* name) {
        QuietProgress progress;
        EXPECT_TRUE(test::runOn({volume}, jobOf(0.0, 8, "residual"), dir / name, progress).ok());
        return progress.notes;
    };
    EXPECT_THAT(notesOf("a.mote"), testing::IsEmpty());
    // Now from air to bone.
    for (auto& value : volume.values) value = value * 12.0F - 1000.0F;
    EXPECT_THAT(notesOf("b.mote"), testing::ElementsAre(HasSubstr("as scanners write them")));
}

TEST(VolumeJob, WhatIsNotFiniteIsCountedAndTheLeastValue) {
    const test::TempDir dir;
    constexpr double infinite = std::numeric_limits<double>::infinity();
    auto volume = sample(20, 20, 20, ScalarType::f32);
    const float least = *std::min_element(volume.values.begin(), volume.values.end());
    for (const std::size_t at : {0, 4000, 7999}) volume.values[at] = std::nanf("");
    volume.values[17] = static_cast<float>(infinite);
    volume.values[18] = static_cast<float>(-infinite);
    QuietProgress progress;
    ASSERT_TRUE(test::runOn({volume}, jobOf(0.0, 8, "residual"), dir / "a.mote", progress).ok());
    EXPECT_THAT(progress.notes, testing::ElementsAre(HasSubstr("5 samples")));
    const Reconstruction made(dir / "a.mote", 0);
    EXPECT_EQ(made.entry().invalid(), 5U);
    for (auto& value : volume.values) value = std::isfinite(value) ? value : least;
    expectWithin(volume, made, 0.5);
    const test::TempDir other;
    for (auto& value : volume.values) value = std::nanf("");
    make({volume}, jobOf(0.0, 8, "both"), other / "a.mote");
}

TEST(VolumeJob, TimeSeriesShareTheirRange) {
    const test::TempDir dir;
    std::vector<Volume> series{sample(20, 20, 20), sample(20, 20, 20)};
    for (auto& value : series[1].values) value = value * 0.5F + 40.0F;
    make(series, jobOf(0.05, 8, "both"), dir / "a.mote");
    const auto manifest = *storage::readManifest(dir / "a.mote");
    ASSERT_EQ(manifest.hybrid().steps_size(), 2);
    EXPECT_EQ(manifest.hybrid().steps(0).threshold(), manifest.hybrid().steps(1).threshold());
    EXPECT_EQ(manifest.hybrid().steps(1).time(), 1.0);
    for (int step = 0; step < 2; ++step) {
        const Reconstruction made(dir / "a.mote", static_cast<std::uint32_t>(step));
        expectWithin(series[static_cast<std::size_t>(step)], made, made.entry().threshold());
    }
    series[1] = sample(20, 20, 21);
    QuietProgress progress;
    const auto refused = test::runOn(series, jobOf(0.05, 8, "both"), dir / "b.mote", progress);
    ASSERT_FALSE(refused.ok());
    EXPECT_THAT(refused.error().message, HasSubstr("another size"));
}

TEST(VolumeJob, CancelledAnywhereItLeavesNothing) {
    const auto volume = sample(40, 40, 70);
    for (long after = 0;; after += 3) {
        const test::TempDir dir;
        QuietProgress progress(after);
        proto::VolumeJob job;
        job.set_max_points(500);
        job.set_representation("both");
        job.set_filter("under:0.1");
        job.set_low(10);
        const auto made = test::runOn({volume}, job, dir / "a.mote", progress);
        if (made.ok()) {
            EXPECT_GT(after, 10);
            break;
        }
        EXPECT_EQ(made.error().code, ErrorCode::cancelled);
        EXPECT_TRUE(fs::is_empty(dir.path()));
    }
}

TEST(VolumeJob, TooLittleMemoryIsSaidAndLeavesNothing) {
    const test::TempDir dir;
    QuietProgress progress;
    const auto volume = sample(45, 38, 41);
    const auto small = test::runOn({volume}, jobOf(0.0, 12, "both"), dir / "a.mote", progress, {1, 50 << 20});
    ASSERT_FALSE(small.ok());
    EXPECT_EQ(small.error().code, ErrorCode::resourceExhausted);
    EXPECT_TRUE(fs::is_empty(dir.path()));
}

TEST(VolumeJob, RefusesRequestsThatMakeNoSense) {
    const auto refused = [](const std::function<void(proto::VolumeJob&)>& change) {
        const test::TempDir dir;
        auto job = jobOf(0.1, 8, "both");
        change(job);
        QuietProgress progress;
        const auto made = test::runOn({sample(300, 2, 2)}, job, dir / "a.mote", progress);
        return made.ok() ? std::string() : made.error().where;
    };
    EXPECT_EQ(refused([](auto& job) { job.set_low(0); }), "low");
    EXPECT_EQ(refused([](auto& job) { job.set_error_grid(0); }), "errorGrid");
    EXPECT_EQ(refused([](auto& job) { job.set_max_points(3); }), "threshold");
    EXPECT_EQ(refused([](auto& job) { job.set_threshold(std::nan("")); }), "threshold");
    for (const std::uint64_t most : {std::uint64_t{0}, storage::maxGridSamples + 1, ~std::uint64_t{0}}) {
        EXPECT_EQ(refused([&](auto& job) {
                      job.clear_threshold();
                      job.set_max_points(most);
                  }),
                  "maxPoints");
    }
    EXPECT_EQ(refused([](auto& job) { job.set_filter("under:x"); }), "filter");
    EXPECT_EQ(refused([](auto& job) { job.set_filter("under:1.5"); }), "filter");
    EXPECT_EQ(refused([](auto& job) { job.set_representation("all"); }), "representation");
    EXPECT_EQ(refused([](auto& job) { job.set_point_bytes(6); }), "pointBytes");
    EXPECT_EQ(refused([](auto& job) { job.set_value_bits(12); }), "valueBits");
}

}  // namespace
}  // namespace mote::prep
