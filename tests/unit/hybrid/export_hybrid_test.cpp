// SPDX-License-Identifier: GPL-3.0-or-later
//
// What other tools read of a hybrid volume that was exported, against what was put into it.
#include <gmock/gmock.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include "preprocess/export_vdb.h"
#include "storage/manifest.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::prep {
namespace {

openvdb::FloatGrid::Ptr read(const std::filesystem::path& path, const char* name) {
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(false);
    return openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(name));
}

TEST(ExportHybrid, OtherToolsReadVolumeAndResidual) {
    for (const int bits : {8, 16}) {
        const test::TempDir dir;
        auto manifest = test::smallManifest(5, bits);
        manifest.mutable_hybrid()->set_index_to_world(3, 100.0);  // moved along x
        test::writeSmallHybrid(dir / "a.mote", test::smallPoints(5), manifest);
        const auto made = exportVdb(dir / "a.mote", *storage::readManifest(dir / "a.mote"), 0, dir / "a.vdb");
        ASSERT_TRUE(made.ok()) << made.error().toString();

        // 4 x 3 x 2 samples with the codes 3, 4, 5 and so on; the source has 140 x 80 x 66.
        const auto volume = read(dir / "a.vdb", "volume");
        ASSERT_TRUE(volume);
        EXPECT_EQ(volume->activeVoxelCount(), 24U);
        const double step = 255.0 / (bits == 8 ? 255 : 65535);
        EXPECT_FLOAT_EQ(volume->tree().getValue({0, 0, 0}), static_cast<float>(-10.0 + 3 * step));
        EXPECT_FLOAT_EQ(volume->tree().getValue({1, 2, 1}), static_cast<float>(-10.0 + (3 + 21) * step));
        // Centres of cells of 35 samples, counted from the centre of the first sample.
        EXPECT_TRUE(volume->indexToWorld(openvdb::Vec3d(1, 0, 0))
                        .eq({100.0 + 1.5 * 35 - 0.5, 80.0 / 6 - 0.5, 66.0 / 4 - 0.5}, 1e-12));

        // The bricks of small_hybrid.cpp, in steps of 8; samples of the error grid are 2 apart.
        const auto residual = read(dir / "a.vdb", "residual");
        ASSERT_TRUE(residual);
        EXPECT_EQ(residual->activeVoxelCount(), 3U);
        EXPECT_EQ(residual->tree().getValue({2, 13, 23}), 136.0F);
        EXPECT_EQ(residual->tree().getValue({69, 0, 32}), 8.0F);
        EXPECT_TRUE(residual->indexToWorld(openvdb::Vec3d(69, 0, 32)).eq({100.0 + 138.5, 0.5, 64.5}, 1e-12));
    }
}

TEST(ExportHybrid, StepsThatAreNotThereAndDamageAreSaid) {
    const test::TempDir dir;
    test::writeSmallHybrid(dir / "a.mote", test::smallPoints(5), test::smallManifest(5, 8));
    const auto manifest = *storage::readManifest(dir / "a.mote");
    const auto none = exportVdb(dir / "a.mote", manifest, 1, dir / "a.vdb");
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, ErrorCode::invalidArgument);
    std::filesystem::resize_file(dir / "a.mote/residual-000000.vdb", 300);
    const auto cut = exportVdb(dir / "a.mote", manifest, 0, dir / "a.vdb");
    ASSERT_FALSE(cut.ok());
    EXPECT_THAT(cut.error().where, testing::HasSubstr("residual-000000.vdb"));
    EXPECT_FALSE(std::filesystem::exists(dir / "a.vdb"));
}

}  // namespace
}  // namespace mote::prep
