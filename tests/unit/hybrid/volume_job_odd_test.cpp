// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/volume_job.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "storage/manifest.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/volume_job_run.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;
using storage::GridSize;
using test::expectWithin;
using test::jobOf;
using test::make;
using test::makeVolume;
using test::QuietProgress;
using test::Reconstruction;
using test::sample;
using test::Volume;
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
