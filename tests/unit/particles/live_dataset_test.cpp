// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/live_dataset.h"

#include <gmock/gmock.h>

#include <fstream>
#include <optional>

#include "preprocess/particles/watched_files.h"
#include "protocol/base/json.h"
#include "storage/grow_dataset.h"
#include "storage/manifest.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/job_run.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;
using test::beamStep;
using test::contentOf;
using test::FakeSource;
using test::FakeStep;
using test::requestFor;
using testing::HasSubstr;

/// Each wider and longer than the one before, so that bounds and densities change.
std::vector<FakeStep> widening(std::size_t count) {
    std::vector<FakeStep> steps;
    for (std::size_t i = 0; i < count; ++i) {
        steps.push_back(beamStep(2000 + 500 * i, i + 1, 1.0 + static_cast<double>(i)));
        steps.back().iteration = static_cast<std::int64_t>(10 * i);
    }
    return steps;
}

proto::JobRequest bounded() {
    auto request = requestFor();
    for (const char* name : {"x", "px", "y"}) {
        auto& axis = *request.mutable_particles()->add_bounds();
        axis.set_name(name);
        axis.set_min(-0.05);
        axis.set_max(0.05);
    }
    return request;
}

Result<bool> add(LiveDataset& live, std::vector<FakeStep> steps, LiveDataset::Next next,
                 test::QuietProgress* progress = nullptr, bool whole = true) {
    FakeSource source(std::move(steps));
    test::QuietProgress quiet;
    KeptNotes notes(progress != nullptr ? *progress : quiet, live.notes());
    return live.add(
        source, {"/fake.h5"}, next, [whole] { return whole; }, {}, notes);
}

/// What a dataset of steps that came one by one has in common with one that was made at once.
void expectSameSteps(const fs::path& grown, const fs::path& once) {
    auto files = contentOf(grown), others = contentOf(once);
    for (auto* all : {&files, &others}) {
        all->erase("manifest.json");
        all->erase("manifest.digest");
    }
    EXPECT_EQ(files, others);
    const auto left = storage::readManifest(grown), right = storage::readManifest(once);
    ASSERT_TRUE(left.ok() && right.ok());
    EXPECT_EQ(toJson(left->particles()), toJson(right->particles()));
}

TEST(LiveDataset, ItsStepsAreThoseOfARunThatIsPreparedAtOnce) {
    const test::TempDir dir;
    const auto request = bounded();
    FakeSource all(widening(4));
    ASSERT_TRUE(test::make(request, all, dir / "once.mote").ok());
    auto live = LiveDataset::open(request, dir / "live.mote");
    ASSERT_TRUE(live.ok()) << live.error().toString();
    ASSERT_TRUE(add(*live, widening(2), {{0, 1}}).ok());
    EXPECT_TRUE(storage::verifyDataset(dir / "live.mote").empty());
    EXPECT_FALSE(fs::exists(dir / "live.mote/manifest.digest")) << "two files are not replaced at once";
    const auto first = storage::readManifest(dir / "live.mote");
    ASSERT_TRUE(first.ok());
    EXPECT_TRUE(first->particles().live());
    ASSERT_TRUE(add(*live, widening(4), {{2}}).ok());
    // As one that was killed leaves them.
    std::ofstream(dir / "live.mote/step-000003.h5") << "left";
    std::ofstream(dir / "live.mote/columns-000009.h5") << "left";
    EXPECT_TRUE(storage::verifyDataset(dir / "live.mote").empty());
    ASSERT_TRUE(add(*live, widening(4), {{3}}).ok());
    EXPECT_EQ(live->steps(), 4U);
    ASSERT_TRUE(live->close().ok());
    expectSameSteps(dir / "live.mote", dir / "once.mote");
    EXPECT_TRUE(fs::exists(dir / "live.mote/manifest.digest"));
    EXPECT_TRUE(storage::verifyDataset(dir / "live.mote").empty());
    EXPECT_EQ(test::entriesOf(dir.path()), 2U) << "no draft is left";
}

TEST(LiveDataset, WhatIsGivenUpLeavesItAsItWas) {
    const test::TempDir dir;
    auto live = LiveDataset::open(bounded(), dir / "live.mote");
    ASSERT_TRUE(live.ok());
    ASSERT_TRUE(add(*live, widening(1), {{0}}).ok());
    const auto before = contentOf(dir / "live.mote");
    const auto changed = add(*live, widening(2), {{1}}, nullptr, false);
    ASSERT_TRUE(changed.ok());
    EXPECT_FALSE(*changed) << "its file was written to meanwhile";
    for (const long asked : {0, 5, 30}) {
        test::QuietProgress progress(asked);
        const auto cancelled = add(*live, widening(2), {{1}}, &progress);
        ASSERT_FALSE(cancelled.ok());
        EXPECT_EQ(cancelled.error().code, ErrorCode::cancelled);
    }
    EXPECT_EQ(contentOf(dir / "live.mote"), before);
    EXPECT_EQ(test::entriesOf(dir.path()), 1U);
    ASSERT_TRUE(add(*live, widening(2), {{1}}).ok());
}

TEST(LiveDataset, OnlyTheSamePlotGoesOnAndOneProgramAtATime) {
    const test::TempDir dir;
    std::optional<LiveDataset> live;
    {
        auto opened = LiveDataset::open(bounded(), dir / "live.mote");
        ASSERT_TRUE(opened.ok());
        ASSERT_TRUE(add(*opened, widening(1), {{0}}).ok());
        const auto second = LiveDataset::open(bounded(), dir / "live.mote");
        ASSERT_FALSE(second.ok());
        EXPECT_THAT(second.error().toString(), HasSubstr("another program"));
    }
    const auto other = LiveDataset::open(requestFor("x", "px", "y"), dir / "live.mote");
    ASSERT_FALSE(other.ok());
    EXPECT_THAT(other.error().toString(),
                HasSubstr("bounds: is not that by which the live dataset live.mote"));
    auto again = LiveDataset::open(bounded(), dir / "live.mote");
    ASSERT_TRUE(again.ok()) << again.error().toString();
    auto bare = widening(2);
    for (auto& step : bare) step[Column::z].clear();
    const auto missing = add(*again, std::move(bare), {{1}});
    ASSERT_FALSE(missing.ok());
    EXPECT_THAT(missing.error().toString(), HasSubstr("z"));
    ASSERT_TRUE(again->close().ok());
    const auto closed = LiveDataset::open(bounded(), dir / "live.mote");
    ASSERT_FALSE(closed.ok());
    EXPECT_THAT(closed.error().toString(), HasSubstr("not live"));
}

class GrowthTest : public ::testing::Test {
  protected:
    GrowthTest() {
        auto live = LiveDataset::open(bounded(), dir_ / "live.mote");
        EXPECT_TRUE(live.ok() && add(*live, widening(1), {{0}}).ok());
        now_ = *live->manifest();
        EXPECT_TRUE(add(*live, widening(2), {{1}}).ok());
        next_ = *live->manifest();
    }
    /// What is wrong with `next_` after the change.
    std::string wrong(const std::function<void(proto::Manifest&)>& change) const {
        auto next = next_;
        change(next);
        const auto found = storage::checkGrowth(now_, next);
        return found.ok() ? "" : found.error().toString();
    }

    test::TempDir dir_;
    proto::Manifest now_, next_;
};

TEST_F(GrowthTest, AManifestTakesThePlaceOfOneThatItContinues) {
    EXPECT_EQ(wrong([](auto&) {}), "");
    EXPECT_EQ(wrong([](auto& m) { m.mutable_particles()->set_live(false); }), "");
    const auto particles = [&](auto change) {
        return wrong([&](auto& m) { change(*m.mutable_particles()); });
    };
    EXPECT_THAT(particles([](auto& p) { p.mutable_axes(0)->set_max(1.0); }), HasSubstr("particles.axes"));
    EXPECT_THAT(particles([](auto& p) { p.set_mass(1.0); }), HasSubstr("particles.mass"));
    EXPECT_THAT(particles([](auto& p) { p.mutable_columns(1)->set_name("q"); }),
                HasSubstr("particles.columns"));
    EXPECT_THAT(particles([](auto& p) { p.mutable_steps()->DeleteSubrange(0, 2); }), HasSubstr("fewer"));
    EXPECT_THAT(particles([](auto& p) { p.mutable_steps(0)->set_time(7.0); }), HasSubstr("steps[0]"));
    EXPECT_THAT(wrong([](auto& m) { m.mutable_files(0)->set_size(7); }), HasSubstr("files[0]"));
    EXPECT_THAT(wrong([](auto& m) { m.set_kind("mesh"); }), HasSubstr("kind"));
    auto ended = now_;
    ended.mutable_particles()->set_live(false);
    EXPECT_THAT(storage::checkGrowth(ended, next_).error().toString(), HasSubstr("no live dataset"));
}

TEST_F(GrowthTest, ADraftNamesNoFilesButItsOwn) {
    for (const char* name : {"../gone", "manifest.json", "step-000000.h5", "", "a/b"}) {
        const fs::path draft = dir_ / "draft";
        fs::create_directory(draft);
        auto bad = next_;
        auto& file = *bad.add_files();
        file.set_name(name);
        file.set_xxh3_128(std::string(32, '0'));
        std::ofstream(draft / "manifest.json") << toJson(bad);
        const auto before = contentOf(dir_ / "live.mote");
        const auto lock = storage::GrowthLock::take(dir_ / "live.mote");
        ASSERT_TRUE(lock.ok());
        const auto grown = storage::growDataset(draft, *lock);
        ASSERT_FALSE(grown.ok()) << name;
        EXPECT_EQ(grown.error().code, ErrorCode::corrupt) << grown.error().toString();
        EXPECT_EQ(contentOf(dir_ / "live.mote"), before);
        EXPECT_FALSE(storage::checkBegins(draft).ok()) << "its steps lie elsewhere";
        fs::remove_all(draft);
    }
}

TEST(WatchedFiles, AFileIsCompleteOnceNobodyWritesToIt) {
    const test::TempDir dir;
    WatchedFiles files({dir / "run_%T.csv"});
    ASSERT_TRUE(files.look().ok()) << "none is no error";
    EXPECT_TRUE(files.files().empty());
    std::ofstream(dir / "run_10.csv") << "x\n";
    std::ofstream open(dir / "run_9.csv");
    open << "x,y\n" << std::flush;
    ASSERT_TRUE(files.look().ok());
    ASSERT_EQ(files.files().size(), 2U);
    EXPECT_EQ(files.files()[0].file.path.filename(), "run_9.csv") << "by its number";
    EXPECT_EQ(files.files()[1].state, WatchedFiles::State::changing) << "it was never seen before";
    ASSERT_TRUE(files.look().ok());
    EXPECT_EQ(files.files()[0].state, WatchedFiles::State::open);
    EXPECT_EQ(files.files()[1].state, WatchedFiles::State::complete);
    open.close();
    std::ofstream(dir / "run_10.csv", std::ios::app) << "1\n";
    ASSERT_TRUE(files.look().ok());
    EXPECT_EQ(files.files()[0].state, WatchedFiles::State::complete);
    EXPECT_EQ(files.files()[1].state, WatchedFiles::State::changing);
    fs::remove(dir / "run_9.csv");
    ASSERT_TRUE(files.look().ok());
    EXPECT_EQ(files.files().size(), 1U);
}

}  // namespace
}  // namespace mote::prep
