// SPDX-License-Identifier: GPL-3.0-or-later
//
// The job where its particles do not fit the memory that it may take.
#include <gmock/gmock.h>

#include "preprocess/particles/plot_plan.h"
#include "preprocess/particles/record_store.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/account.h"
#include "tests/unit/particles/job_run.h"

namespace mote::prep {
namespace {

using test::beamStep;
using test::contentOf;
using test::entriesOf;
using test::FakeSource;
using test::make;
using test::requestFor;
using testing::HasSubstr;

constexpr int threads = 2;
const StepOptions defaults{{defaultLeafCapacity, defaultMaxLevel}, defaultVolumeLevel};

/// So little that particles must lie in a file, and yet enough.
std::uint64_t littleMemory(std::uint64_t particles) {
    return planMemory(particles, defaults, std::uint64_t{1} << 40, threads).needed + 1024;
}

TEST(RecordStore, GivesBackWhatWasWrittenWhereverItLies) {
    const test::TempDir dir;
    constexpr std::uint64_t count = 10000;
    for (const bool inFile : {false, true}) {
        auto store = inFile ? RecordStore::inFile(dir.path(), count * 8) : RecordStore::inMemory(count * 8);
        ASSERT_TRUE(store.ok());
        std::vector<std::uint64_t> values(100);
        for (std::uint64_t first = 0; first < count; first += 100) {
            for (std::size_t i = 0; i < 100; ++i) values[i] = 3 * (first + i);
            ASSERT_TRUE(store->write<std::uint64_t>(first, values).ok());
        }
        std::vector<std::uint64_t> buffer;
        for (const std::uint64_t first : {0UL, 77UL, 9900UL}) {
            const auto read = store->read(first, 100, buffer);
            ASSERT_TRUE(read.ok());
            for (std::size_t i = 0; i < 100; ++i) ASSERT_EQ((*read)[i], 3 * (first + i));
        }
        // No name, so nothing that could be left.
        EXPECT_EQ(entriesOf(dir.path()), 0U);
        EXPECT_TRUE(store->read(0, 0, buffer)->empty());
    }
    EXPECT_EQ(RecordStore::inFile(dir / "nowhere", 8).error().code, ErrorCode::notFound);
}

TEST(Spill, TheBytesAreThoseOfAJobInMemory) {
    const test::TempDir dir;
    auto even = beamStep(50000, 2);
    even[Column::weight].assign(50000, 0.25);
    FakeSource source({beamStep(300000, 1), even});
    ASSERT_TRUE(make(requestFor(), source, dir / "memory.mote", {threads, 0}).ok());
    const auto spilled = make(requestFor(), source, dir / "file.mote", {threads, littleMemory(300000)});
    ASSERT_TRUE(spilled.ok()) << spilled.error().toString();
    EXPECT_TRUE(contentOf(dir / "file.mote") == contentOf(dir / "memory.mote"));
    EXPECT_TRUE(storage::verifyDataset(dir / "file.mote").empty());
    test::expectAccounted(dir / "file.mote", requestFor().particles(), source);
    EXPECT_EQ(entriesOf(dir.path()), 2U);
}

TEST(Spill, AFullDiskIsOneErrorAndNoDebris) {
    const test::TempDir dir;
    FakeSource source({beamStep(20000, 1)});
    // Of the temporary file; of the step's, which is larger.
    for (const rlim_t bytes : {100000UL, 500000UL}) {
        const test::FileSizeLimit limit(bytes);
        const auto made = make(requestFor(), source, dir / "a.mote", {threads, littleMemory(20000)});
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::resourceExhausted) << made.error().toString();
        EXPECT_EQ(entriesOf(dir.path()), 0U);
    }
}

TEST(Spill, CancelledAnywhereLeavesNoDebris) {
    const test::TempDir dir;
    bool done = false;
    for (long after = 0; !done; ++after) {
        FakeSource source({beamStep(2000, 1)});
        test::QuietProgress progress(after);
        const auto made = runParticlesJob(requestFor(), source, {dir / "fake.h5"}, dir / "a.mote",
                                          {threads, littleMemory(2000)}, progress);
        done = made.ok();
        if (done) continue;
        EXPECT_EQ(made.error().code, ErrorCode::cancelled);
        EXPECT_EQ(entriesOf(dir.path()), 0U);
    }
}

TEST(Spill, WhatIsNeededIsSaidAndIsEnough) {
    const test::TempDir dir;
    FakeSource source({beamStep(20000, 1)});
    const auto needed = planMemory(20000, defaults, std::uint64_t{1} << 40, threads).needed;
    const auto refused = make(requestFor(), source, dir / "a.mote", {threads, needed - 1});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(refused.error().message, HasSubstr("needs at least 0.02 GB"));
    EXPECT_TRUE(make(requestFor(), source, dir / "a.mote", {threads, needed + 1024}).ok());
}

}  // namespace
}  // namespace mote::prep
