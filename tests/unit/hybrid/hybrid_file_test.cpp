// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/hybrid_file.h"

#include <gmock/gmock.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <fstream>
#include <functional>
#include <map>

#include "storage/hash.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/residual_file.h"
#include "storage/manifest.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;
using test::smallManifest;
using test::smallPoints;
using test::writeSmallHybrid;
using testing::HasSubstr;

struct Form {
    int pointBytes, valueBits;
};

class HybridFile : public testing::TestWithParam<Form> {};

TEST_P(HybridFile, ReadsBackWhatWasWritten) {
    const auto [bytes, bits] = GetParam();
    const test::TempDir dir;
    writeSmallHybrid(dir / "a.mote", smallPoints(bytes), smallManifest(bytes, bits));
    const auto manifest = readManifest(dir / "a.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    const auto step = HybridStep::open(dir / "a.mote", *manifest, 0);
    ASSERT_TRUE(step.ok()) << step.error().toString();
    EXPECT_EQ(step->lowSize(), (GridSize{4, 3, 2}));
    std::visit([](auto codes) { EXPECT_EQ(codes[23], 26); }, step->low());
    EXPECT_EQ(step->low().index(), bits == 8 ? 0U : 1U);
    EXPECT_EQ(step->lowNormal()[1], 4);
    std::vector<GridSize> places;
    std::vector<int> codes;
    step->points().forEach([&](const HybridPoint& point) {
        places.push_back(point.place);
        codes.insert(codes.end(), {point.value, point.error, point.normal});
    });
    EXPECT_THAT(places, testing::ElementsAre(GridSize{0, 0, 0}, GridSize{31, 31, 31}, GridSize{69, 1, 2},
                                             GridSize{32, 39, 5}, GridSize{64, 39, 32}));
    EXPECT_THAT(codes, testing::ElementsAre(0, 1, 0, 50, 61, 1, 100, 121, 2, 150, 181, 3, 200, 241, 4));
    const auto errors = verifyDataset(dir / "a.mote");
    EXPECT_TRUE(errors.empty()) << errors.front().toString();
}

INSTANTIATE_TEST_SUITE_P(AllForms, HybridFile, testing::Values(Form{5, 8}, Form{6, 16}, Form{9, 8}));

TEST(HybridFile, CodesMeanValuesAndErrors) {
    const auto manifest = smallManifest(5, 8);
    EXPECT_EQ(pointValue(manifest.hybrid(), 0), -10.0);
    EXPECT_EQ(pointValue(manifest.hybrid(), 255), 245.0);
    EXPECT_EQ(pointError(manifest.hybrid().steps(0), 1), -254.0);
    EXPECT_EQ(pointError(manifest.hybrid().steps(0), 128), 0.0);
}

TEST(HybridFile, ResidualsComeBackAsExactMultiples) {
    const test::TempDir dir;
    writeSmallHybrid(dir / "a.mote", smallPoints(5), smallManifest(5, 8));
    const auto manifest = readManifest(dir / "a.mote");
    ASSERT_TRUE(manifest.ok());
    std::map<std::pair<GridSize, std::size_t>, float> values;
    const auto read = readResidual(dir / "a.mote", *manifest, 0, [&](const ResidualBrick& brick) {
        for (std::size_t i = 0; i < brick.values.size(); ++i) {
            if (brick.values[i] != 0.0F) values[{brick.index, i}] = brick.values[i];
        }
    });
    ASSERT_TRUE(read.ok()) << read.error().toString();
    const std::map<std::pair<GridSize, std::size_t>, float> expected{
        {{{0, 1, 2}, 0}, -24.0F}, {{{0, 1, 2}, 490}, 136.0F}, {{{8, 0, 4}, 5}, 8.0F}};
    EXPECT_EQ(values, expected);
}

TEST(HybridFile, AnyOpenVdbToolReadsTheResidual) {
    const test::TempDir dir;
    writeSmallHybrid(dir / "a.mote", smallPoints(5), smallManifest(5, 8));
    openvdb::initialize();
    openvdb::io::File file((dir / "a.mote/residual-000000.vdb").string());
    file.open(true);  // voxels are read when they are used
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("residual"));
    ASSERT_TRUE(grid);
    EXPECT_EQ(grid->metaValue<openvdb::Vec3i>("file_bbox_min"), openvdb::Vec3i(0, 0, 16));
    EXPECT_EQ(grid->metaValue<openvdb::Vec3i>("file_bbox_max"), openvdb::Vec3i(69, 13, 32));
    EXPECT_EQ(grid->metaValue<openvdb::Int64>("file_voxel_count"), 3);
    // Brick (0, 1, 2) begins at (0, 8, 16); its sample 490 is 2 + 8 * 5 + 64 * 7.
    EXPECT_EQ(grid->tree().getValue({2, 13, 23}), 136.0F);
    EXPECT_EQ(grid->activeVoxelCount(), 3U);
    EXPECT_EQ(grid->indexToWorld(openvdb::Vec3d(1, 2, 3)), openvdb::Vec3d(2, 4, 6));
}

/// Steps that no half could hold, and such that it can: the same multiples come back.
TEST(HybridFile, ResidualStepsOfAllSizes) {
    for (const double step : {1e-9, 0.3, 1.0, 250.0}) {
        for (const std::int32_t greatest : {1, 999, 70000}) {
            const test::TempDir dir;
            auto manifest = smallManifest(0, 8);
            auto& entry = *manifest.mutable_hybrid()->mutable_steps(0);
            entry.set_residual_step(step);
            entry.set_residual_samples(512);
            entry.set_residual_bricks(1);
            std::array<std::int32_t, 512> multiples{};
            for (int i = 0; i < 512; ++i) {
                multiples[static_cast<std::size_t>(i)] = i % 2 ? greatest - i / 2 : -1 - i;
                if (multiples[static_cast<std::size_t>(i)] == 0) multiples[static_cast<std::size_t>(i)] = 7;
            }
            const ResidualCoding coding{test::smallErrorGrid, step, glm::dmat4(1.0),
                                        fitHalves(std::max(greatest, 512), step)};
            test::writeBricks({{{1, 1, 1}, multiples}}, coding, dir / "residual-000000.vdb");
            const auto hash = hashFile(dir / "residual-000000.vdb");
            auto& file = *manifest.add_files();
            file.set_name("residual-000000.vdb");
            file.set_size(hash->size);
            file.set_xxh3_128(hash->xxh3_128);
            const auto read = readResidual(dir.path(), manifest, 0, [&](const ResidualBrick& brick) {
                for (std::size_t i = 0; i < 512; ++i) {
                    EXPECT_EQ(brick.values[i], static_cast<float>(multiples[i] * step));
                }
            });
            EXPECT_TRUE(read.ok()) << read.error().toString();
        }
    }
}

TEST(HybridFile, SameContentSameBytes) {
    const test::TempDir dir;
    for (const auto* name : {"a.mote", "b.mote"}) {
        writeSmallHybrid(dir / name, smallPoints(5), smallManifest(5, 8));
    }
    for (const auto* file : {"step-000000.h5", "residual-000000.vdb", "manifest.json"}) {
        EXPECT_EQ(hashFile(dir / "a.mote" / file)->xxh3_128, hashFile(dir / "b.mote" / file)->xxh3_128);
    }
}

void expectRefused(int bytes, const std::function<void(test::SmallPoints&)>& change, const char* array) {
    const test::TempDir dir;
    auto points = smallPoints(bytes);
    change(points);
    writeSmallHybrid(dir / "a.mote", points, smallManifest(bytes, 8));
    const auto step = HybridStep::open(dir / "a.mote", *readManifest(dir / "a.mote"), 0);
    ASSERT_FALSE(step.ok()) << array;
    EXPECT_EQ(step.error().code, ErrorCode::corrupt);
    EXPECT_THAT(step.error().where, HasSubstr(array));
    EXPECT_EQ(verifyDataset(dir / "a.mote").size(), 1U);
}

TEST(HybridFile, RefusesPointsThatContradictThemselves) {
    expectRefused(
        5, [](auto& points) { points.advance[2] = 6; }, "/points/advance");
    expectRefused(
        5, [](auto& points) { points.brickBegin[3] = 7; }, "/bricks/begin");
    expectRefused(
        5, [](auto& points) { points.brickBegin[12] = 4; }, "/bricks/begin");
    expectRefused(
        6, [](auto& points) { points.place8[4] = 40; }, "/points/place");
    expectRefused(
        9, [](auto& points) { points.place16[14] = 33; }, "/points/place");
}

TEST(HybridFile, FindsDamage) {
    for (const auto* name : {"step-000000.h5", "residual-000000.vdb"}) {
        const test::TempDir dir;
        writeSmallHybrid(dir / "a.mote", smallPoints(5), smallManifest(5, 8));
        std::fstream file(dir / "a.mote" / name, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(-3, std::ios::end);
        file.put('!');
        file.close();
        EXPECT_FALSE(verifyDataset(dir / "a.mote").empty()) << name;
        const auto manifest = readManifest(dir / "a.mote");
        const auto residual = readResidual(dir / "a.mote", *manifest, 0, [](const ResidualBrick&) {});
        EXPECT_EQ(residual.ok(), std::string_view(name) == "step-000000.h5");
    }
}

TEST(HybridFile, ALinkIsNoResidual) {
    const test::TempDir dir;
    writeSmallHybrid(dir / "a.mote", smallPoints(5), smallManifest(5, 8));
    const auto file = dir / "a.mote" / "residual-000000.vdb";
    // The same bytes, so that no hash tells.
    std::filesystem::rename(file, dir / "elsewhere");
    std::filesystem::create_symlink(dir / "elsewhere", file);
    const auto residual = readResidual(dir / "a.mote", *readManifest(dir / "a.mote"), 0,
                                       [](const ResidualBrick&) { ADD_FAILURE() << "was read"; });
    ASSERT_FALSE(residual.ok());
    EXPECT_EQ(residual.error().where, file.string());
    EXPECT_THAT(residual.error().message, HasSubstr("is a link"));
}

void expectManifestRefused(const std::function<void(proto::HybridManifest&)>& change, const char* field) {
    const test::TempDir dir;
    writeSmallHybrid(dir / "a.mote", smallPoints(5), smallManifest(5, 8));
    auto manifest = *readManifest(dir / "a.mote");
    change(*manifest.mutable_hybrid());
    const auto checked = checkManifest(manifest);
    ASSERT_FALSE(checked.ok()) << field;
    EXPECT_EQ(checked.error().where, field);
}

TEST(HybridFile, RefusesManifestsThatContradictThemselves) {
    using Hybrid = proto::HybridManifest;
    expectManifestRefused([](Hybrid& h) { h.set_low_size(1, 0); }, "hybrid.lowSize");
    expectManifestRefused([](Hybrid& h) { h.add_error_size(3); }, "hybrid.errorSize");
    expectManifestRefused([](Hybrid& h) { h.set_source_size(0, 65537); }, "hybrid.sourceSize");
    expectManifestRefused(
        [](Hybrid& h) {
            for (int i = 0; i < 3; ++i) h.set_error_size(i, 65536);
        },
        "hybrid.errorSize");
    expectManifestRefused([](Hybrid& h) { h.set_index_to_world(5, 0.0); }, "hybrid.indexToWorld");
    expectManifestRefused([](Hybrid& h) { h.set_value_max(-11.0); }, "hybrid.valueMin");
    expectManifestRefused([](Hybrid& h) { h.set_value_bits(12); }, "hybrid.valueBits");
    expectManifestRefused([](Hybrid& h) { h.set_point_bytes(7); }, "hybrid.pointBytes");
    expectManifestRefused([](Hybrid& h) { h.clear_steps(); }, "hybrid.steps");
    expectManifestRefused([](Hybrid& h) { h.mutable_steps(0)->set_histogram(1, 1); },
                          "hybrid.steps[0].histogram");
    expectManifestRefused([](Hybrid& h) { h.mutable_steps(0)->set_residual_file("x.vdb"); },
                          "hybrid.steps[0].residualFile");
    expectManifestRefused([](Hybrid& h) { h.mutable_steps(0)->set_residual_step(0.0); },
                          "hybrid.steps[0].residualStep");
    expectManifestRefused([](Hybrid& h) { h.mutable_steps(0)->set_points(92401); }, "hybrid.steps[0].points");
}

}  // namespace
}  // namespace mote::storage
