// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <limits>

#include "storage/manifest.h"
#include "storage/particles/step_layout.h"
#include "storage/storage_error.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/forged_digest.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::storage {
namespace {

using test::TinyDataset;

Result<std::shared_ptr<const ParticleStep>> openTinyStep(const std::filesystem::path& dataset) {
    return ParticleStep::open(dataset, *readManifest(dataset), 0);
}

TEST(StepPreview, AFileWithoutOneIsWholeAndHasNone) {
    const test::TempDir dir;
    const TinyDataset tiny;
    tiny.write(dir / "a.mote");
    test::forgeDigest(dir / "a.mote", [](proto::Digest& digest) {
        for (int i = 0; i < 2; ++i) digest.mutable_arrays()->RemoveLast();
    });
    const auto step = openTinyStep(dir / "a.mote");
    ASSERT_TRUE(step.ok()) << step.error().toString();
    const auto preview = (*step)->preview(Preview::mostPoints);
    EXPECT_TRUE(preview.points.empty());
    EXPECT_TRUE(preview.threshold.empty());
    EXPECT_EQ(preview.total, 0U);
    EXPECT_EQ((*step)->rows(0, 2)[1], tiny.row[1]);
    EXPECT_TRUE(verifyDataset(dir / "a.mote").empty());
}

TEST(StepPreview, HalfOfOneOrOneOfTheWrongSizeIsAnErrorAtOpen) {
    const auto points = static_cast<int>(StepArray::previewPoint);
    const auto threshold = static_cast<int>(StepArray::previewThreshold);
    const std::vector<std::function<void(proto::Digest&)>> changes{
        [&](auto& digest) { digest.mutable_arrays(threshold)->set_shape(0, 1); },
        [&](auto& digest) { digest.mutable_arrays(points)->set_shape(0, 4096); },
        [&](auto& digest) { digest.mutable_arrays(points)->set_shape(1, 3); },
        [&](auto& digest) { digest.mutable_arrays()->DeleteSubrange(points, 1); },
        [&](auto& digest) { digest.mutable_arrays()->DeleteSubrange(threshold, 1); },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        SCOPED_TRACE(i);
        const test::TempDir dir;
        TinyDataset().write(dir / "a.mote");
        test::forgeDigest(dir / "a.mote", changes[i]);
        const auto step = openTinyStep(dir / "a.mote");
        ASSERT_FALSE(step.ok());
        EXPECT_EQ(step.error().code, ErrorCode::corrupt);
    }
    // More than a quarter of the step's points.
    const test::TempDir dir;
    TinyDataset tiny;
    tiny.preview.resize(TinyDataset::points / 4 + 1);
    tiny.threshold.resize(tiny.preview.size() / Preview::blockPoints + 1, 0.5F);
    tiny.write(dir / "a.mote");
    const auto step = openTinyStep(dir / "a.mote");
    ASSERT_FALSE(step.ok());
    EXPECT_EQ(step.error().code, ErrorCode::corrupt);
}

TEST(StepPreview, ThresholdsOrDensitiesOutOfOrderAreAnErrorAtUse) {
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    constexpr float infinite = std::numeric_limits<float>::infinity();
    const std::vector<std::function<void(TinyDataset&)>> changes{
        [](auto& tiny) { tiny.threshold = {0.5F, 0.125F}; },
        [](auto& tiny) { tiny.threshold = {none, 0.5F}; },
        [](auto& tiny) { tiny.threshold = {0.5F, none}; },
        [](auto& tiny) { tiny.threshold = {-0.5F, 0.5F}; },
        [](auto& tiny) { tiny.threshold = {0.5F, 1.5F}; },
        [](auto& tiny) { tiny.leafDensity = {2.0F, 1.0F}; },
        [](auto& tiny) { tiny.leafDensity = {-1.0F, none}; },
        [](auto& tiny) { tiny.leafDensity = {1.0F, infinite}; },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        SCOPED_TRACE(i);
        const test::TempDir dir;
        TinyDataset tiny;
        changes[i](tiny);
        tiny.write(dir / "a.mote");
        const auto step = openTinyStep(dir / "a.mote");
        ASSERT_TRUE(step.ok());
        EXPECT_THROW((*step)->preview(1), StorageError);
        const auto errors = verifyDataset(dir / "a.mote");
        ASSERT_EQ(errors.size(), 1U);
        EXPECT_EQ(errors.front().code, ErrorCode::corrupt);
    }
}

TEST(StepPreview, LeavesThatWeighNothingAreNoPartOfItsScale) {
    const test::TempDir dir;
    TinyDataset tiny;
    tiny.leafDensity = {0.0F, 16e5F};
    tiny.density = {3e5F, 16e5F, 0.0F};
    tiny.minDensity = {0.0F, 16e5F, 0.0F};
    tiny.write(dir / "a.mote");
    const auto preview = (*openTinyStep(dir / "a.mote"))->preview(1);
    EXPECT_EQ(preview.scale.min, 16e5);
    EXPECT_EQ(preview.scale.max, 16e5);
    EXPECT_TRUE(verifyDataset(dir / "a.mote").empty());
}

}  // namespace
}  // namespace mote::storage
