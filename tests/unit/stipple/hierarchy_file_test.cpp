// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "server/render/layers/stipple/dot_cells.h"
#include "server/render/layers/stipple/photograph.h"
#include "server/render/layers/stipple/plane_tiles.h"
#include "server/render/layers/stipple/replay.h"
#include "storage/hash.h"
#include "storage/manifest.h"
#include "storage/particles/particle_step.h"
#include "storage/stipple/stipple_hierarchy.h"
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

namespace mote::render {
namespace {

constexpr std::uint32_t side = 240;
constexpr double full = 0.05;  // dots a square pixel

/// From nothing at the left edge to the full density at the right one, and white below.
PixelMap ramp() {
    std::vector<float> values(std::size_t{side} * side);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const bool white = i / side >= 200;
        values[i] = white ? 0.0F : static_cast<float>(full * static_cast<double>(i % side) / side);
    }
    return {side, side, std::move(values)};
}

class PhotographTest : public ::testing::Test {
  protected:
    std::vector<TileDot> dotsOf(const PixelMap& wanted, const PhotographEffort& effort) const {
        return stipplePhotograph(tiles_, wanted, {full}, effort);
    }

    /// Root mean square of how far cells are from holding one dot.
    double unevenness(const PixelMap& wanted, const std::vector<TileDot>& dots) const {
        std::vector<glm::vec2> places;
        for (const auto& dot : dots) places.push_back(dot.place);
        double sum = 0.0;
        for (const auto& cell : dotCells(wanted, places)) sum += (cell.mass - 1.0) * (cell.mass - 1.0);
        return std::sqrt(sum / static_cast<double>(dots.size()));
    }

    PlaneTiles tiles_{std::make_shared<const storage::StippleHierarchy>(test::jitteredGrid(60))};
};

/// Each dot that is drawn or left out wrongly counts one way or the other: of N independent ones 4 sqrt(N) is
/// four standard deviations, and neither selection nor balance is worse than chance.
TEST_F(PhotographTest, countsAreTheTone) {
    const auto wanted = ramp();
    const double total = wanted.total();
    const auto quick = dotsOf(wanted, quickPhotograph);
    EXPECT_NEAR(static_cast<double>(quick.size()), total, 4.0 * std::sqrt(total));
    const auto fine = dotsOf(wanted, finePhotograph);
    EXPECT_NEAR(static_cast<double>(fine.size()), total, 4.0 * std::sqrt(total));
}

TEST_F(PhotographTest, effortMakesCellsEven) {
    const auto wanted = ramp();
    const double plain = unevenness(wanted, dotsOf(wanted, {false, 0}));
    const double fine = unevenness(wanted, dotsOf(wanted, finePhotograph));
    EXPECT_LT(fine, 0.6 * plain);
}

TEST_F(PhotographTest, dotsLieInsideAndWhereInkIs) {
    const auto wanted = ramp();
    for (const auto& effort : {PhotographEffort{false, 0}, quickPhotograph, finePhotograph}) {
        std::set<std::tuple<int, int, std::uint32_t>> seen;
        for (const auto& dot : dotsOf(wanted, effort)) {
            EXPECT_TRUE(seen.emplace(dot.column, dot.row, dot.point).second);  // each point is one dot
            EXPECT_GE(dot.place.x, 0.0F);
            EXPECT_LT(dot.place.x, static_cast<float>(side));
            EXPECT_GE(dot.place.y, 0.0F);
            // Cells at the edge are some spacings large where the ramp begins: 4 / sqrt(0.01).
            EXPECT_LT(dot.place.y, 240.0F);
        }
    }
}

TEST_F(PhotographTest, whiteAndBlackAndTiny) {
    const auto even = [](std::uint32_t size, double density) {
        return PixelMap(size, size,
                        std::vector<float>(std::size_t{size} * size, static_cast<float>(density)));
    };
    EXPECT_TRUE(dotsOf(even(50, 0.0), finePhotograph).empty());
    EXPECT_NEAR(static_cast<double>(dotsOf(even(200, full), finePhotograph).size()), 2000.0, 60.0);
    EXPECT_LE(dotsOf(even(1, full), finePhotograph).size(), 1u);
    EXPECT_LE(dotsOf(even(3, 1e-30), finePhotograph).size(), 1u);
}

TEST_F(PhotographTest, sameOnAnyThreads) {
    const auto wanted = ramp();
    const auto all = dotsOf(wanted, finePhotograph);
    tbb::task_arena one(1);
    const auto alone = one.execute([&] { return dotsOf(wanted, finePhotograph); });
    ASSERT_EQ(all.size(), alone.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(all[i].place, alone[i].place);
        EXPECT_EQ(all[i].point, alone[i].point);
    }
}

TEST_F(PhotographTest, luminanceOfAPicture) {
    const Picture picture{2, 1, PixelFormat::srgb8, {255, 0, 0, 255, 255, 255, 255, 255}, 0};
    const auto luminance = luminanceOf(picture);
    EXPECT_FLOAT_EQ(luminance.at(0, 0), 0.2126F);
    EXPECT_NEAR(luminance.at(1, 0), 1.0, 1e-6);
}

using storage::StippleHierarchy;

/// Random points that move at random when one of their nearest is removed: what matters here is who moves for
/// whom and across which seam, not how evenly.
StippleHierarchy randomHierarchy(std::uint32_t points) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    StippleHierarchy h;
    for (std::uint32_t i = 0; i < points; ++i) h.positions.push_back({unit(random), unit(random), 0.0F});
    h.normals.assign(points, {0, 0, 1});
    h.removal.resize(points);
    std::iota(h.removal.begin(), h.removal.end(), 0U);
    std::shuffle(h.removal.begin(), h.removal.end(), random);
    h.deathArea.assign(points, 1.0F);
    h.locked.assign(points, 0);
    h.movesBegin = {0};
    for (std::uint32_t i = 0; i < points; ++i) {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> earlier;  // removal, point
        for (std::uint32_t j = 0; j < points; ++j) {
            auto apart = h.positions[i] - h.positions[j];
            apart -= glm::vec3(std::round(apart.x), std::round(apart.y), 0.0F);
            if (std::hypot(apart.x, apart.y) < 0.12F && h.removal[j] < h.removal[i])
                earlier.emplace_back(h.removal[j], j);
        }
        std::sort(earlier.begin(), earlier.end());
        for (const auto& [removal, point] : earlier) {
            h.moveNeighbour.push_back(point);
            h.movePosition.push_back(h.positions[i] +
                                     0.05F * glm::vec3(unit(random) - 0.5F, unit(random) - 0.5F, 0));
        }
        h.movesBegin.push_back(h.moveNeighbour.size());
    }
    return h;
}

PixelMap even(std::uint32_t width, std::uint32_t height, double density) {
    return {width, height, std::vector<float>(std::size_t{width} * height, static_cast<float>(density))};
}

class PlaneTilesTest : public ::testing::Test {
  protected:
    StippleHierarchy hierarchy_ = randomHierarchy(400);
    PlaneTiles tiles_{std::make_shared<const StippleHierarchy>(hierarchy_)};
};

/// Every tile of an even density is the replay of the hierarchy itself.
TEST_F(PlaneTilesTest, evenDensityIsTheReplay) {
    const StippleReplay replay(hierarchy_);
    constexpr double full = 400.0 / (100.0 * 100.0);  // tiles of 100 pixels
    for (const double share : {0.1, 0.35, 0.8, 1.0}) {
        const auto drawn = replay.select(std::vector<float>(400, static_cast<float>(share)));
        const auto wanted = even(300, 250, share * full);
        auto selection = tiles_.select(wanted, {full});
        tiles_.place(selection);
        std::size_t inMiddle = 0;
        for (const auto& dot : selection.dots) {
            EXPECT_EQ(drawn[dot.point], 1) << share;
            if (dot.column != 1 || dot.row != 1) continue;
            ++inMiddle;
            auto place = hierarchy_.positions[dot.point];
            for (auto m = hierarchy_.movesBegin[dot.point]; m < hierarchy_.movesBegin[dot.point + 1]; ++m) {
                if (drawn[hierarchy_.moveNeighbour[m]] != 0) break;
                place = hierarchy_.movePosition[m];
            }
            EXPECT_NEAR(dot.place.x, 100.0 * (1.0 + place.x), 1e-3);
            EXPECT_NEAR(dot.place.y, 100.0 * (1.0 + place.y), 1e-3);
        }
        EXPECT_EQ(inMiddle, static_cast<std::size_t>(std::accumulate(drawn.begin(), drawn.end(), 0)));
    }
}

/// Where the density varies, each dot of each tile obeys its neighbours' nearest images.
TEST_F(PlaneTilesTest, movesAcrossSeams) {
    constexpr double full = 400.0 / (100.0 * 100.0);
    std::vector<float> density(std::size_t{300} * 300);
    for (std::size_t i = 0; i < density.size(); ++i) {
        density[i] = static_cast<float>(full * (0.5 + 0.5 * std::sin(0.07 * static_cast<double>(i % 300)) *
                                                          std::cos(0.05 * static_cast<double>(i / 300))));
    }
    auto selection = tiles_.select({300, 300, density}, {full});
    tiles_.place(selection);
    std::map<std::tuple<int, int, std::uint32_t>, bool> drawn;
    for (const auto& dot : selection.dots) drawn[{dot.column, dot.row, dot.point}] = true;
    ASSERT_GT(selection.dots.size(), 1000u);
    std::size_t moved = 0;
    for (const auto& dot : selection.dots) {
        glm::vec3 expected = hierarchy_.positions[dot.point];
        for (auto m = hierarchy_.movesBegin[dot.point]; m < hierarchy_.movesBegin[dot.point + 1]; ++m) {
            const auto neighbour = hierarchy_.moveNeighbour[m];
            // Of the neighbour's nine images the nearest.
            std::tuple<float, int, int> nearest{1e9F, 0, 0};
            for (int dx = -1; dx <= 1; ++dx) {
                for (int dy = -1; dy <= 1; ++dy) {
                    const auto apart = hierarchy_.positions[neighbour] +
                                       glm::vec3(static_cast<float>(dx), static_cast<float>(dy), 0.0F) -
                                       hierarchy_.positions[dot.point];
                    nearest = std::min(nearest, {std::hypot(apart.x, apart.y), dx, dy});
                }
            }
            if (drawn.contains(
                    {dot.column + std::get<1>(nearest), dot.row + std::get<2>(nearest), neighbour}))
                break;
            expected = hierarchy_.movePosition[m];
            ++moved;
        }
        EXPECT_NEAR(dot.place.x, 100.0F * (static_cast<float>(dot.column) + expected.x), 1e-3);
        EXPECT_NEAR(dot.place.y, 100.0F * (static_cast<float>(dot.row) + expected.y), 1e-3);
    }
    EXPECT_GT(moved, 1000u);
}

TEST_F(PlaneTilesTest, nothingIsWantedNothingIsDrawn) {
    EXPECT_TRUE(tiles_.select(even(50, 50, 0.0), {0.04}).dots.empty());
}

/// One point, a tile smaller than a pixel, and a picture of one pixel.
TEST_F(PlaneTilesTest, extremes) {
    StippleHierarchy one = randomHierarchy(1);
    const PlaneTiles single(std::make_shared<const StippleHierarchy>(one));
    auto selection = single.select(even(30, 20, 0.01), {0.01});
    single.place(selection);
    const auto inside = std::count_if(selection.dots.begin(), selection.dots.end(), [](const TileDot& dot) {
        return dot.place.x >= 0 && dot.place.x < 30 && dot.place.y >= 0 && dot.place.y < 20;
    });
    EXPECT_EQ(inside, 6);
    EXPECT_FALSE(single.select(even(1, 1, 4.0), {4.0}).dots.empty());
}

TEST_F(PlaneTilesTest, wakesTheNearestThatSleeps) {
    constexpr double full = 400.0 / (100.0 * 100.0);
    auto selection = tiles_.select(even(200, 200, 0.5 * full), {full});
    const auto before = selection.drawn;
    const auto woken = tiles_.wake(selection, {123.0, 45.0});
    ASSERT_TRUE(woken.has_value());
    const auto changed = std::inner_product(before.begin(), before.end(), selection.drawn.begin(), 0,
                                            std::plus<>(), std::not_equal_to<>());
    EXPECT_EQ(changed, 1);
    const auto first = hierarchy_.positions[woken->point];
    const auto gap = [](double x, double y) { return std::hypot(x - 123.0, y - 45.0); };
    const double found = gap(100.0 * (woken->column + first.x), 100.0 * (woken->row + first.y));
    for (std::uint32_t i = 0; i < 400; ++i) {
        for (int column = 0; column < 2; ++column) {
            const auto flag = selection.tiling.index(column, 0) * 400 + i;
            const auto& place = hierarchy_.positions[i];
            EXPECT_TRUE(before[flag] != 0 || gap(100.0 * (column + place.x), 100.0 * place.y) >= found);
        }
    }
    tiles_.letSleep(selection, *woken);
    EXPECT_EQ(selection.drawn, before);
}

TEST_F(PlaneTilesTest, sameOnAnyThreads) {
    constexpr double full = 400.0 / (40.0 * 40.0);
    const auto wanted = even(300, 300, 0.4 * full);
    auto all = tiles_.select(wanted, {full});
    tiles_.place(all);
    tbb::task_arena arena(1);
    arena.execute([&] {
        auto alone = tiles_.select(wanted, {full});
        tiles_.place(alone);
        ASSERT_EQ(alone.dots.size(), all.dots.size());
        for (std::size_t i = 0; i < all.dots.size(); ++i) EXPECT_EQ(alone.dots[i].place, all.dots[i].place);
    });
}

}  // namespace
}  // namespace mote::render
