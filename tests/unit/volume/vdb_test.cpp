// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenVDB volumes: the grids that can be read, where their voxels lie, and files without one.
#include <gmock/gmock.h>
#include <openvdb/openvdb.h>

#include <fstream>

#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"
#include "tests/unit/volume/volume_files.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAreArray;
using testing::HasSubstr;

class Vdb : public testing::Test {
  protected:
    static void SetUpTestSuite() { openvdb::initialize(); }

    /// By OpenVDB's own table of kinds: Grid::create would have all of its code compiled here, minutes of it.
    template <class Grid>
    static typename Grid::Ptr empty() {
        return openvdb::StaticPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
    }

    /// Voxels 0, 1, 2, ... of a box from (-2, 3, 5) on, 0 of them not active.
    template <class Grid>
    typename Grid::Ptr counted(int nx, int ny, int nz, const std::string& name) {
        auto grid = empty<Grid>();
        grid->setName(name);
        for (int i = 0; i < nx * ny * nz; ++i) {
            grid->tree().setValue({i % nx - 2, i / nx % ny + 3, i / (nx * ny) + 5},
                                  static_cast<typename Grid::ValueType>(i));
        }
        return grid;
    }

    fs::path write(const openvdb::GridCPtrVec& grids, bool statistics = true) {
        openvdb::io::File file((folder_ / "a.vdb").string());
        file.setGridStatsMetadataEnabled(statistics);
        file.write(grids);
        file.close();
        return folder_ / "a.vdb";
    }

    static proto::VolumeSourceOptions named(const std::string& field) {
        proto::VolumeSourceOptions options;
        options.set_field(field);
        return options;
    }

    TempDir folder_;
};

TEST_F(Vdb, GridsOfEachTypeAreRead) {
    const auto numbers = countedNumbers(60);
    const auto path =
        write({counted<openvdb::FloatGrid>(3, 4, 5, "f"), counted<openvdb::DoubleGrid>(3, 4, 5, "d"),
               counted<openvdb::Int32Grid>(3, 4, 5, "i")});
    for (const auto& [field, type] : std::vector<std::pair<std::string, std::string>>{
             {"", "f32"}, {"f", "f32"}, {"d", "f64"}, {"i", "i32"}}) {
        const auto volume = must(readVolume(path, named(field)));
        EXPECT_EQ(volume.format, "vdb");
        EXPECT_EQ(name(volume.shape.type), type);
        EXPECT_THAT(volume.values, ElementsAreArray(numbers));
    }
}

TEST_F(Vdb, SparseGridsHaveTheirBackground) {
    auto grid = empty<openvdb::FloatGrid>();
    grid->tree().root().setBackground(-1.0F, false);
    grid->tree().setValue({0, 0, 0}, 5.0F);
    grid->tree().setValue({40, 20, 30}, 7.0F);
    grid->tree().fill(openvdb::CoordBBox({8, 8, 8}, {15, 15, 15}), 3.0F);  // a tile, or a leaf
    const auto volume = must(readVolume(write({grid})));
    ASSERT_EQ(volume.shape.voxels(), 41u * 21 * 31);
    const auto at = [&](std::size_t x, std::size_t y, std::size_t z) {
        return volume.values[x + 41 * (y + 21 * z)];
    };
    EXPECT_EQ(at(0, 0, 0), 5.0F);
    EXPECT_EQ(at(40, 20, 30), 7.0F);
    EXPECT_EQ(at(1, 0, 0), -1.0F);
    EXPECT_EQ(at(15, 8, 12), 3.0F);
    EXPECT_EQ(at(16, 8, 12), -1.0F);
    EXPECT_EQ(std::count(volume.values.begin(), volume.values.end(), 3.0F), 512);
}

// A grid of more than 256 MiB of voxels comes in several windows of slices, in any order.
TEST_F(Vdb, LongGridsAreReadInWindows) {
    auto grid = empty<openvdb::FloatGrid>();
    for (const int z : {0, 16383, 16384, 20000, 39999}) {
        grid->tree().setValue({0, 0, z}, 1.0F);
        grid->tree().setValue({63, 63, z}, static_cast<float>(z));
    }
    const auto path = write({grid});
    const std::vector<std::uint32_t> slices = {20000, 0, 16384, 39999, 16383, 5, 20000};
    const auto values = readSlices(path, slices);
    ASSERT_EQ(values.size(), 64u * 64 * slices.size());
    for (std::size_t i = 0; i < slices.size(); ++i) {
        EXPECT_EQ(values[4096 * i], slices[i] == 5 ? 0.0F : 1.0F);
        EXPECT_EQ(values[4096 * i + 4095], slices[i] == 5 ? 0.0F : static_cast<float>(slices[i]));
    }
    QuietProgress progress;
    auto source = prep::openVolumeSource({}, path, progress);
    ASSERT_TRUE(source.ok());
    std::vector<float> across(4096u * 20);
    ASSERT_TRUE((*source)->read(16374, 16394, across).ok());
    EXPECT_EQ(across[4096 * 9 + 4095], 16383.0F);
    EXPECT_EQ(across[4096 * 10 + 4095], 16384.0F);
    EXPECT_EQ(std::count(across.begin(), across.end(), 0.0F), 4096 * 20 - 4);
}

TEST_F(Vdb, LiesWhereItsTransformSays) {
    auto grid = counted<openvdb::FloatGrid>(2, 2, 2, "f");
    const openvdb::Mat4d map(0.0, 2.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 10.0, 20.0, 30.0,
                             1.0);  // of row vectors
    grid->setTransform(openvdb::math::Transform::createLinearTransform(map));
    const auto volume = must(readVolume(write({grid})));
    const auto expected = [&](int x, int y, int z) {
        const openvdb::Vec3d at = grid->indexToWorld(openvdb::Coord(x - 2, y + 3, z + 5));
        return glm::dvec3(at[0], at[1], at[2]);
    };
    EXPECT_EQ(worldOf(volume.shape, 0, 0, 0), expected(0, 0, 0));
    EXPECT_EQ(worldOf(volume.shape, 1, 0, 1), expected(1, 0, 1));
    EXPECT_EQ(worldOf(volume.shape, 0, 1, 0), expected(0, 1, 0));
    EXPECT_THAT(volume.values, ElementsAreArray(countedNumbers(8)));
}

TEST_F(Vdb, FilesWithoutAGridToReadAreRefused) {
    EXPECT_THAT(volumeError(write({})), HasSubstr("not_found: a.vdb: holds no grid"));
    auto vectors = empty<openvdb::Vec3SGrid>();
    vectors->setName("v");
    EXPECT_THAT(volumeError(write({vectors})),
                HasSubstr("unsupported: a.vdb: grid \"v\": holds values of type vec3s; only float"));
    const auto both = write({vectors, counted<openvdb::FloatGrid>(2, 2, 2, "f")});
    EXPECT_EQ(volumeError(both), "");
    EXPECT_THAT(volumeError(both, named("v")), HasSubstr("holds values of type vec3s"));
    EXPECT_THAT(volumeError(both, named("x")), HasSubstr("holds no grid of the name \"x\""));
    EXPECT_THAT(volumeError(write({empty<openvdb::FloatGrid>()})), HasSubstr("no voxels"));
    EXPECT_THAT(volumeError(write({counted<openvdb::FloatGrid>(2, 2, 2, "f")}, false)),
                HasSubstr("does not say which box"));
    auto wide = empty<openvdb::FloatGrid>();
    wide->tree().setValue({0, 0, 0}, 1.0F);
    wide->tree().setValue({1000000, 1000000, 1000000}, 1.0F);
    EXPECT_THAT(volumeError(write({wide})),
                HasSubstr("resource_exhausted: a.vdb: grid \"\": says 1000001 x"));
    auto frustum = counted<openvdb::FloatGrid>(2, 2, 2, "f");
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd({-10, -10, -10}, {10, 10, 10}), 0.5, 1.0));
    EXPECT_THAT(volumeError(write({frustum})), HasSubstr("has a transform that is not linear"));
}

/// OpenVDB takes memory for any length that a file says.
TEST_F(Vdb, LengthsThatAFileCannotHaveAreRefused) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "the sanitizers end a program that gets no memory";
#endif
    const auto path = write({counted<openvdb::FloatGrid>(2, 2, 2, "f")});
    // Behind the header (57 bytes), no metadata and the count of grids: the first grid's name.
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(65);
    file.write("\xff\xff\xff\x7f", 4);
    file.close();
    EXPECT_THAT(volumeError(path), HasSubstr("resource_exhausted: a.vdb: asks for more memory"));
    write({counted<openvdb::FloatGrid>(2, 2, 2, "f")});
    EXPECT_EQ(volumeError(path), "");
}

TEST_F(Vdb, CutFilesAreRefused) {
    const auto path = write({counted<openvdb::FloatGrid>(20, 20, 20, "f")});
    const auto size = fs::file_size(path);
    for (const auto left : {std::uintmax_t{9}, std::uintmax_t{100}, size / 2, size - 10}) {
        fs::resize_file(path, left);
        EXPECT_THAT(volumeError(path), HasSubstr("corrupt: a.vdb: ")) << left;
        write({counted<openvdb::FloatGrid>(20, 20, 20, "f")});
    }
}

}  // namespace
}  // namespace mote::test
