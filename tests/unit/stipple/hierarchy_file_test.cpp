// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/stipple/stipple_hierarchy.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

#include "storage/hash.h"
#include "storage/manifest.h"
#include "storage/particles/particle_step.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;
using test::manifestOf;
using test::smallHierarchy;
using test::writeDataset;
using testing::HasSubstr;

Result<StippleHierarchy> readFrom(const fs::path& dataset) {
    const auto manifest = readManifest(dataset);
    if (!manifest.ok()) return manifest.error();
    return readHierarchy(dataset, *manifest);
}

void expectEqual(const StippleHierarchy& a, const StippleHierarchy& b) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.removal, b.removal);
    EXPECT_EQ(a.deathArea, b.deathArea);
    EXPECT_EQ(a.locked, b.locked);
    EXPECT_EQ(a.movesBegin, b.movesBegin);
    EXPECT_EQ(a.moveNeighbour, b.moveNeighbour);
    EXPECT_EQ(a.movePosition, b.movePosition);
}

/// Publishes a hierarchy that was changed, and expects it to be refused where and why both readers say.
void expectRefused(const std::function<void(StippleHierarchy&)>& change, const std::string& array,
                   const std::string& why) {
    const test::TempDir dir;
    auto hierarchy = smallHierarchy();
    change(hierarchy);
    writeDataset(dir / "a.mote", hierarchy, manifestOf(hierarchy));
    const auto read = readFrom(dir / "a.mote");
    ASSERT_FALSE(read.ok()) << array;
    EXPECT_EQ(read.error().code, ErrorCode::corrupt);
    EXPECT_THAT(read.error().where, HasSubstr("hierarchy.h5:" + array));
    EXPECT_THAT(read.error().message, HasSubstr(why));
    const auto errors = verifyDataset(dir / "a.mote");
    ASSERT_EQ(errors.size(), 1U);
    EXPECT_EQ(errors[0].where, read.error().where);
}

TEST(HierarchyFile, ReadsBackWhatWasWritten) {
    const test::TempDir dir;
    const auto hierarchy = smallHierarchy();
    writeDataset(dir / "a.mote", hierarchy, manifestOf(hierarchy));
    const auto read = readFrom(dir / "a.mote");
    ASSERT_TRUE(read.ok()) << read.error().toString();
    expectEqual(*read, hierarchy);
    EXPECT_TRUE(verifyDataset(dir / "a.mote").empty());
}

TEST(HierarchyFile, ASinglePointWithoutMoves) {
    const test::TempDir dir;
    const StippleHierarchy one{{{0.5F, 0.5F, 0.0F}}, {{0, 0, 1}}, {0}, {1.0F}, {0}, {0, 0}, {}, {}};
    writeDataset(dir / "a.mote", one, manifestOf(one));
    const auto read = readFrom(dir / "a.mote");
    ASSERT_TRUE(read.ok()) << read.error().toString();
    expectEqual(*read, one);
}

TEST(HierarchyFile, SameContentSameBytes) {
    const test::TempDir dir;
    for (const auto* name : {"a.mote", "b.mote"}) {
        writeDataset(dir / name, smallHierarchy(), manifestOf(smallHierarchy()));
    }
    for (const auto* file : {"hierarchy.h5", "hierarchy.digest", "manifest.json"}) {
        EXPECT_EQ(hashFile(dir / "a.mote" / file)->xxh3_128, hashFile(dir / "b.mote" / file)->xxh3_128);
    }
}

TEST(HierarchyFile, RefusesContentThatContradictsItself) {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    constexpr float infinity = std::numeric_limits<float>::infinity();
    expectRefused([](auto& h) { h.removal[1] = 4; }, "/points/rank", "no permutation");
    expectRefused([](auto& h) { h.removal[1] = 5; }, "/points/rank", "no permutation");
    expectRefused([](auto& h) { h.positions[2].y = nan; }, "/points/position", "entry 2");
    expectRefused([](auto& h) { h.positions[3].z = 1e38F; }, "/points/position", "entry 3");
    expectRefused([](auto& h) { h.movePosition[1].y = -2e18F; }, "/moves/position", "entry 1");
    expectRefused([](auto& h) { h.normals[4].z = infinity; }, "/points/normal", "entry 4");
    expectRefused([](auto& h) { h.normals[2].x = 1e38F; }, "/points/normal", "entry 2");
    expectRefused([](auto& h) { h.normals[0].y = std::nanf(""); }, "/points/normal", "entry 0");
    expectRefused([](auto& h) { h.movePosition[0].x = nan; }, "/moves/position", "entry 0");
    expectRefused([](auto& h) { h.deathArea[0] = nan; }, "/points/death_area", "entry 0");
    expectRefused([](auto& h) { h.deathArea[3] = -1.0F; }, "/points/death_area", "entry 3");
    expectRefused([](auto& h) { h.locked[0] = 2; }, "/points/locked", "entry 0");
    expectRefused([](auto& h) { h.movesBegin[1] = 4; }, "/points/moves_begin", "ascend");
    expectRefused([](auto& h) { h.movesBegin[0] = 1; }, "/points/moves_begin", "ascend");
    expectRefused([](auto& h) { h.movesBegin[5] = 6; }, "/points/moves_begin", "ascend");
    expectRefused([](auto& h) { h.movesBegin[2] = ~std::uint64_t{0}; }, "/points/moves_begin", "ascend");
    expectRefused([](auto& h) { h.moveNeighbour[3] = 5; }, "/moves/neighbour", "not one of the points");
    expectRefused([](auto& h) { h.moveNeighbour[0] = 4; }, "/moves/neighbour", "order of removal");
    expectRefused([](auto& h) { h.moveNeighbour[2] = 3; }, "/moves/neighbour", "order of removal");
    expectRefused([](auto& h) { h.moveNeighbour[2] = 1; }, "/moves/neighbour", "order of removal");
}

TEST(HierarchyFile, AnyFlippedBitOfTheArraysIsFound) {
    const test::TempDir dir;
    writeDataset(dir / "a.mote", smallHierarchy(), manifestOf(smallHierarchy()));
    const auto path = dir / "a.mote" / "hierarchy.h5";
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    const auto size = fs::file_size(path);
    for (std::uint64_t at = 0; at < size; at += 7) {
        file.seekg(static_cast<std::streamoff>(at));
        const char before = static_cast<char>(file.get());
        const auto put = [&](char byte) {
            file.seekp(static_cast<std::streamoff>(at));
            file.put(byte).flush();
        };
        put(static_cast<char>(before ^ 4));
        EXPECT_FALSE(verifyDataset(dir / "a.mote").empty()) << "byte " << at;
        const auto read = readFrom(dir / "a.mote");
        // What lies between the arrays is HDF5's, and not read.
        if (read.ok()) expectEqual(*read, smallHierarchy());
        put(before);
    }
    EXPECT_TRUE(verifyDataset(dir / "a.mote").empty());
}

TEST(HierarchyFile, CountsAreTheManifests) {
    const test::TempDir dir;
    auto manifest = manifestOf(smallHierarchy());
    manifest.mutable_stipple()->set_points(6);
    writeDataset(dir / "a.mote", smallHierarchy(), manifest);
    const auto read = readFrom(dir / "a.mote");
    ASSERT_FALSE(read.ok());
    EXPECT_THAT(read.error().toString(), HasSubstr("has the shape [5, 3], not [6, 3]"));
}

TEST(HierarchyFile, MissingAndTruncatedFilesAreErrors) {
    const test::TempDir dir;
    writeDataset(dir / "a.mote", smallHierarchy(), manifestOf(smallHierarchy()));
    fs::resize_file(dir / "a.mote" / "hierarchy.h5", 100);
    EXPECT_EQ(readFrom(dir / "a.mote").error().code, ErrorCode::corrupt);
    fs::remove(dir / "a.mote" / "hierarchy.h5");
    EXPECT_EQ(readFrom(dir / "a.mote").error().code, ErrorCode::notFound);
    EXPECT_EQ(verifyDataset(dir / "a.mote").size(), 1U);
}

TEST(StippleManifest, EveryFieldIsChecked) {
    const auto refused = [](const std::function<void(proto::StippleManifest&)>& change, const char* field) {
        const test::TempDir dir;
        auto manifest = manifestOf(smallHierarchy());
        writeDataset(dir / "a.mote", smallHierarchy(), manifest);
        manifest = *readManifest(dir / "a.mote");
        change(*manifest.mutable_stipple());
        const auto checked = checkManifest(manifest);
        ASSERT_FALSE(checked.ok()) << field;
        EXPECT_EQ(checked.error().where, std::string("stipple") + field);
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    refused([](auto& s) { s.set_domain(proto::StippleManifest::DOMAIN_UNSPECIFIED); }, ".domain");
    refused([](auto& s) { s.set_points(0); }, ".points");
    refused([](auto& s) { s.set_points(1ULL << 32); }, ".points");
    refused([](auto& s) { s.set_locked(6); }, ".locked");
    refused([](auto& s) { s.set_area(nan); }, ".area");
    refused([](auto& s) { s.set_rings(3); }, ".rings");
    refused([](auto& s) { s.set_relaxation(nan); }, ".relaxation");
    refused([](auto& s) { s.set_relaxation(2.0); }, ".relaxation");
}

TEST(StippleManifest, IsNoParticlePlot) {
    const test::TempDir dir;
    writeDataset(dir / "a.mote", smallHierarchy(), manifestOf(smallHierarchy()));
    const auto step = ParticleStep::open(dir / "a.mote", *readManifest(dir / "a.mote"), 0);
    ASSERT_FALSE(step.ok());
    EXPECT_THAT(step.error().message, HasSubstr("kind \"stipple\""));
}

}  // namespace
}  // namespace mote::storage
