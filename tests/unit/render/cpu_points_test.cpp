// SPDX-License-Identifier: GPL-3.0-or-later
//
// The cpu device's points against plain loops in double precision, on every instruction set that runs here.
#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/point_footprint.h"
#include "server/render/cpu/point_groups.h"
#include "server/render/cpu/tile_points.h"
#include "server/render/layers/make_frame_plan.h"
#include "server/render/plan/octree_cell.h"
#include "server/render/plan/screen_map.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/random.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

struct PlainPoint {
    double x, y, slab;  ///< pixels, slabs
    float density;      ///< of its leaf
};

/// The points that a plan's only layer draws, from its leaves, where the eye sees them.
std::vector<PlainPoint> plainPoints(const FramePlan& plan) {
    const PointsPlan& layer = plan.points.at(0);
    const auto leaves = layer.step->leaves();
    const auto nodes = layer.step->nodes();
    const glm::dmat4 toScreen = boxToScreen(plan, layer.boxToEye);
    std::vector<PlainPoint> points;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const auto node = leaves.node[i];
        const double edge = std::ldexp(1.0, -nodes.level[node]);
        const glm::dvec3 place(cellPlace(nodes.morton[node]));
        for (const auto& p : layer.step->positions(leaves.pointBegin[i], layer.drawn(i))) {
            const glm::dvec3 box = edge * (place + (glm::dvec3(p.x, p.y, p.z) + 0.5) / 65536.0);
            const glm::dvec4 at = toScreen * glm::dvec4(box, 1.0);
            if (plan.camera.perspective() && at.w < plan.nearDepth) continue;
            points.push_back({at.x / at.w, at.y / at.w, at.z, leaves.density[i]});
        }
    }
    return points;
}

bool inPicture(const FramePlan& plan, const PlainPoint& point) {
    return point.x >= 0.0 && point.x < plan.width && point.y >= 0.0 && point.y < plan.height;
}

std::vector<std::uint32_t> plainCounts(const FramePlan& plan) {
    std::vector<std::uint32_t> counts(std::size_t{plan.width} * plan.height, 0);
    for (const auto& point : plainPoints(plan)) {
        if (!inPicture(plan, point)) continue;
        ++counts[static_cast<std::size_t>(point.y) * plan.width + static_cast<std::size_t>(point.x)];
    }
    return counts;
}

template <class Numbers>
double distance(const Numbers& a, const std::vector<std::uint32_t>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < b.size(); ++i) sum += std::abs(static_cast<double>(a[i]) - b[i]);
    return sum;
}

/// Single precision places a point to about 1e-4 pixels (24 bits for 1000 pixels), so that of a thousand
/// points a fifth of one changes its pixel, which is a distance of two.
double allowance(const std::vector<std::uint32_t>& counts) {
    return 4.0 + 1e-3 * std::accumulate(counts.begin(), counts.end(), 0.0);
}

const char* const cameras[] = {
    "'camera': {'eye': [1, 2, 4], 'target': [0, 0, 0]}",
    "'camera': {'eye': [0.1, 0.05, 0.3], 'target': [0, 0, 0]}",
    "'camera': {'eye': [2, 1, 3], 'target': [0, 0, 0], 'orthographicHeight': 2.2}",
    "'camera': {'eye': [2, 1, 3], 'target': [0.1, 0, 0], 'orthographicHeight': 0.05}",
    "'camera': {'eye': [0, 0, 200], 'target': [0, 0, 0]}"};

Scene scene(const std::string& camera, const std::string& look = "") {
    static const auto step = test::MemoryStep::make(
        test::beam({.core = 30000, .halo = 6000, .filaments = 2000}), {.leafCapacity = 24});
    const std::string points = "'linked': false, 'curve': [{'density': 0, 'fraction': 1}]" + look;
    return {test::viewOf("{'width': 203, 'height': 121, " + camera +
                         ", 'layers': [{'particles': {'volume': {'curve': [{'density': 0}]}, 'points': {" +
                         points + "}}}]}"),
            {{.step = step}}};
}

/// Of points so faint that no pixel is full of them.
const char* const faint = ", 'opacity': 0.000001";

FlatPoints flatPoints(const FramePlan& plan) {
    LeafCells cells;
    FlatPoints flat;
    const PointsPlan& layer = plan.points.at(0);
    EXPECT_TRUE(flat.draw(plan, layer, cells.upTo(*layer.step, layer.selection->drawn.size()), nullptr,
                          PixelFormat::srgb8, {}));
    return flat;
}

std::vector<std::uint32_t> flatCounts(const FramePlan& plan) {
    const FlatPoints flat = flatPoints(plan);
    return {flat.counts().begin(), flat.counts().end()};
}

std::vector<std::uint8_t> pictureOf(const FramePlan& plan, const FlatPoints& points) {
    return flatPicture(plan, plan.points[0], points, nullptr, PixelFormat::srgb8).pixels;
}

/// The weights of all tiles' cells by pixel, and the sum of how deep their points lie.
struct Gathered {
    std::vector<double> weight;
    double depth = 0.0;
    std::vector<PixelShade> shades = {};  ///< by pixel, if they are shaded
};

/// What points are gathered from.
enum class From { leaves, groups };

Gathered gather(const FramePlan& plan, From from = From::leaves) {
    LeafCells leafCells;
    TilePoints points;
    const PointsPlan& layer = plan.points.at(0);
    const auto leaves = leafCells.upTo(*layer.step, layer.selection->drawn.size());
    const auto groups = from == From::groups ? groupPoints(layer, leaves, {}) : nullptr;
    EXPECT_TRUE(points.sort(plan, layer, leaves, groups, nullptr, {}));
    Gathered sums{std::vector<double>(std::size_t{plan.width} * plan.height, 0.0)};
    if (points.shaded()) sums.shades.resize(sums.weight.size());
    TileCells cells(plan.slabs, 0, points.shaded());
    for (std::uint32_t row = 0; row < tilesAcross(plan.height); ++row) {
        for (std::uint32_t column = 0; column < tilesAcross(plan.width); ++column) {
            cells.clear();
            points.gather({column, row}, cells);
            EXPECT_EQ(cells.empty(), !points.any({column, row}) || cells.empty());
            for (std::uint32_t y = 0; y < Tile::edge && row * Tile::edge + y < plan.height; ++y) {
                for (std::uint32_t x = 0; x < Tile::edge && column * Tile::edge + x < plan.width; ++x) {
                    const std::uint32_t pixel = Tile::pixelIndex(x, y);
                    const std::size_t at =
                        std::size_t{row * Tile::edge + y} * plan.width + column * Tile::edge + x;
                    if (cells.shaded()) sums.shades[at] = cells.shades()[pixel];
                    for (std::uint32_t slab = 0; slab < plan.slabs; ++slab) {
                        const PointCell cell = cells.slab(slab)[pixel];
                        if (cell.weight > 0.0F) {
                            EXPECT_TRUE(cells.occupied(slab) >> (pixel / Tile::packetPixels) & 1);
                        }
                        sums.weight[at] += cell.weight;
                        sums.depth += cell.weight * slab + cell.depth;
                    }
                }
            }
        }
    }
    return sums;
}

class CpuPointsTest : public testing::TestWithParam<std::int64_t> {
  protected:
    void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
    void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(CpuPointsTest, FlatCountsAreThePlainOnes) {
    for (const auto* camera : cameras) {
        const auto plan = makeFramePlan(scene(camera, faint), Quality::exact());
        const auto expected = plainCounts(plan);
        EXPECT_LE(distance(flatCounts(plan), expected), allowance(expected)) << camera;
    }
}

TEST_P(CpuPointsTest, NothingIsMissedBehindAFullPixel) {
    double leftOut = 0.0;
    for (const auto* camera : cameras) {
        const auto all = flatCounts(makeFramePlan(scene(camera, faint), Quality::exact()));
        for (const char* look : {", 'opacity': 1", ", 'opacity': 0.2"}) {
            const auto plan = makeFramePlan(scene(camera, look), Quality::exact());
            const auto drawn = flatPoints(plan);
            FlatPoints counted;
            counted.take(all);
            EXPECT_EQ(pictureOf(plan, drawn), pictureOf(plan, counted)) << camera << look;
            const double left = std::accumulate(all.begin(), all.end(), 0.0) -
                                std::accumulate(drawn.counts().begin(), drawn.counts().end(), 0.0);
            EXPECT_GE(left, 0.0) << camera << look;
            leftOut += left;
        }
    }
    EXPECT_GT(leftOut, 1000.0);
}

TEST_P(CpuPointsTest, GatheredCellsHoldThePlainPoints) {
    for (const auto* camera : cameras) {
        const auto plan = makeFramePlan(scene(camera), {.slabs = 24});
        const auto expected = plainCounts(plan);
        double depth = 0.0;
        for (const auto& point : plainPoints(plan)) depth += inPicture(plan, point) ? point.slab : 0.0;
        for (const From from : {From::leaves, From::groups}) {
            const auto gathered = gather(plan, from);
            EXPECT_LE(distance(gathered.weight, expected), allowance(expected)) << camera;
            // Points that change their pixel at the picture's edge take their depth with them.
            EXPECT_NEAR(gathered.depth, depth, plan.slabs * allowance(expected)) << camera;
        }
    }
}

TEST_P(CpuPointsTest, DiscsAreSpreadAlikeFlatAndInTiles) {
    for (std::size_t way = 0; way < 2 * std::size(cameras); ++way) {
        const auto* const camera = cameras[way / 2];
        const auto plan =
            makeFramePlan(scene(camera, faint + std::string(", 'sizePixels': 4.5")), {.slabs = 8});
        const auto flat = flatCounts(plan);
        const auto gathered = gather(plan, way % 2 == 0 ? From::leaves : From::groups);
        for (std::size_t i = 0; i < flat.size(); ++i) {
            // Each of the discs that meet in a pixel is rounded to a 256th there; some 16 pixels a disc.
            const double each = gathered.weight[i];
            EXPECT_NEAR(flat[i] / 256.0, each, 1e-3 + each * 0.1 + 0.02) << camera << ' ' << i;
        }
        const double sum = std::accumulate(gathered.weight.begin(), gathered.weight.end(), 0.0);
        EXPECT_NEAR(std::accumulate(flat.begin(), flat.end(), 0.0) / 256.0, sum, 0.01 * sum + 1e-3);
    }
}

/// Points within and around a picture of 50 x 40 pixels.
std::vector<ScreenPoint> somePlaces() {
    test::Random random(11);
    std::vector<ScreenPoint> places;
    for (int i = 0; i < 300; ++i) {
        places.push_back(
            {static_cast<float>(random.between(-12.0, 62.0)), static_cast<float>(random.between(-12.0, 52.0)),
             static_cast<float>(random.between(0.0, 3.0)), static_cast<float>(random.between(0.0, 255.0))});
    }
    return places;
}

/// Their weights in a pixel as discs, and the sum of weight * place in the slab, in double precision.
struct PlainCell {
    double weight = 0.0, depth = 0.0;
};
PlainCell plainCell(const std::vector<ScreenPoint>& places, double size, double opacity, double column,
                    double row) {
    PlainCell sum;
    for (const auto& place : places) {
        const double d = std::hypot(column + 0.5 - double{place.x}, row + 0.5 - double{place.y});
        const double coverage = std::clamp(size / 2.0 + 0.5 - d, 0.0, 1.0);
        const double weight =
            opacity > 0.0 ? std::log1p(-opacity * coverage) / std::log1p(-opacity) : coverage;
        sum.weight += weight;
        sum.depth += weight * (double{place.slab} - std::floor(double{place.slab}));
    }
    return sum;
}

/// The greatest slope of the weight by coverage: where all is covered.
double steepestWeight(double opacity) {
    return opacity > 0.0 ? -opacity / ((1.0 - opacity) * std::log1p(-opacity)) : 1.0;
}

TEST_P(CpuPointsTest, DiscsCoverAsDefined) {
    const auto places = somePlaces();
    PointMap map{};
    map.width = 50;
    map.height = 40;
    for (const double size : {1.2, 2.0, 4.5, 9.0, 21.0, 64.0}) {
        for (const double opacity : {0.0, 0.001, 0.4, 0.97}) {
            SCOPED_TRACE(testing::Message() << "size " << size << ", opacity " << opacity);
            const DiscFootprint disc(size, opacity);
            FlatDiscs flat{disc.reach(), {}};
            for (std::size_t i = 0; i < flat.units.size(); ++i)
                flat.units[i] = static_cast<std::uint32_t>(std::lround(disc.weights()[i] * 65536.0F));
            std::vector<std::uint32_t> counts(std::size_t{50} * 40 + spareCounts, 0);
            countScreenDiscs(map, places.data(), places.size(), flat, counts.data());
            TileCells cells(3);
            gatherScreenDiscs(places.data(), places.size(), disc, {1, 0}, cells);
            cells.settle();
            const double steepest = steepestWeight(opacity);
            for (std::uint32_t row = 0; row < 40; ++row) {
                for (std::uint32_t column = 0; column < 50; ++column) {
                    const auto expected = plainCell(places, size, opacity, column, row);
                    // Coverage is told to a 1024th there, and no more than 300 discs meet; here a disc's
                    // place is rounded to 2^-17 at most, the logarithm to 3e-5 of itself, opacity of a 512th
                    // is not told from less (o / 8), and sums of 300 are rounded to 2^-24 of them each.
                    const double discs = std::ceil(expected.weight) + 2.0 * size;
                    EXPECT_NEAR(counts[row * 50 + column] / 65536.0, expected.weight,
                                discs * steepest / 2048);
                    if (column < Tile::edge || row >= Tile::edge) continue;
                    PlainCell gathered;
                    const std::uint32_t pixel = Tile::pixelIndex(column - Tile::edge, row);
                    for (std::uint32_t slab = 0; slab < 3; ++slab) {
                        const PointCell cell = cells.slab(slab)[pixel];
                        gathered.weight += double{cell.weight};
                        gathered.depth += double{cell.depth};
                        EXPECT_TRUE(cell.weight == 0.0F ||
                                    (cells.occupied(slab) >> (pixel / Tile::packetPixels) & 1) != 0);
                    }
                    const double allowance = discs * (steepest * 1e-5 + 3e-5 + 0.001 / 8.0) + 1e-4;
                    EXPECT_NEAR(gathered.weight, expected.weight, allowance);
                    EXPECT_NEAR(gathered.depth, expected.depth, allowance);
                }
            }
            EXPECT_TRUE(std::all_of(counts.begin() + 50 * 40, counts.end(),
                                    [](std::uint32_t count) { return count == 0; }));
        }
    }
}

TEST_P(CpuPointsTest, ThePreviewIsTheShareOfTheLeavesThatItStandsFor) {
    for (const double share : {0.05, 0.2}) {
        // So faint that those that are drawn can hide what they stand for, and stay of one pixel.
        const auto whole = scene("'camera': {'eye': [2, 4, 8], 'target': [0, 0, 0]}", ", 'opacity': 0.01");
        SelectionCache selections;
        const auto fromLeaves = makeFramePlan(whole, {.pointFraction = share, .slabs = 24}, selections, {});
        const auto preview =
            makeFramePlan(whole, {.pointFraction = share, .slabs = 24}, selections, {.preview = true});
        ASSERT_NE(preview.points[0].preview, nullptr);
        EXPECT_EQ(preview.points[0].selection->points, 0U);
        const auto expected = plainCounts(fromLeaves);
        const double points = std::accumulate(expected.begin(), expected.end(), 0.0);
        // Its positions are rounded to a 65536th of the box, here a 500th of a pixel across: of the points
        // one in 250 changes its pixel. Its thresholds hold for blocks of 4096 points: up to a block more.
        const double most = 4.0 + 2.0 * points / 250.0 + storage::Preview::blockPoints;
        EXPECT_LE(distance(flatCounts(preview), expected), most) << share;
        EXPECT_EQ(distance(gather(preview).weight, flatCounts(preview)), 0.0) << share;
    }
}

TEST_P(CpuPointsTest, AStreamShowsThePointsOfTheLeaves) {
    // In motion, of a plot that lies wholly in view; discs and single pixels.
    for (const char* look : {"", ", 'sizePixels': 3"}) {
        const auto whole = scene("'camera': {'eye': [2, 4, 8], 'target': [0, 0, 0]}", look);
        const auto moving = makeFramePlan(whole, {.slabs = 24});
        const auto exact = makeFramePlan(whole, {.slabs = Quality::exact().slabs});
        ASSERT_FALSE(moving.exact);
        ASSERT_TRUE(exact.exact);
        const PointMap map = PointMap::make(moving, moving.points[0]);
        ASSERT_TRUE(PointStream::serves(moving, moving.points[0], map));
        EXPECT_FALSE(PointStream::serves(exact, exact.points[0], map));
        const auto streamed = gather(moving);
        const auto leaves = gather(exact);
        double apart = 0.0, sum = 0.0;
        for (std::size_t i = 0; i < leaves.weight.size(); ++i) {
            apart += std::abs(streamed.weight[i] - leaves.weight[i]);
            sum += leaves.weight[i];
        }
        // As for the preview: one point in 250 changes its pixel; of a disc, its edge.
        EXPECT_LE(apart, 4.0 + 2.0 * sum / 250.0) << look;
        // A slab is eight times as thick in motion.
        EXPECT_NEAR(8.0 * streamed.depth, leaves.depth, 0.01 * leaves.depth) << look;
    }
}

constexpr PointShade shade{{0.3, 1.2}, {0.75, 1.0}};

/// Colours a layer's points by density.
void shadePoints(PointsPlan& layer, const PointShade& by) {
    layer.colors = PointColors{.values = nullptr, .shade = by};
    if (layer.preview != nullptr) return;
    layer.selection = std::make_shared<const PointSelection>(selectPoints(*layer.step, layer.choice()));
}

/// What the levels of a plan's points add up to, discs of a size or points of a pixel.
std::vector<PixelShade> plainShades(const FramePlan& plan, double size) {
    std::vector<PixelShade> sums(std::size_t{plan.width} * plan.height);
    const LogDensity scale = plan.points[0].step->logDensity();
    for (const auto& point : plainPoints(plan)) {
        const double t = scale.ofLeaf(double{point.density});
        const double level =
            std::round(255.0 * std::clamp((t - shade.t.low) / (shade.t.high - shade.t.low), 0.0, 1.0));
        const double reach = size > 1.0 ? size / 2.0 + 1.5 : 0.0;
        const auto first = [&](double at) { return static_cast<std::int64_t>(std::floor(at - reach)); };
        for (auto row = first(point.y); static_cast<double>(row) <= point.y + reach; ++row) {
            for (auto column = first(point.x); static_cast<double>(column) <= point.x + reach; ++column) {
                if (row < 0 || column < 0 || row >= plan.height || column >= plan.width) continue;
                const double d = std::hypot(static_cast<double>(column) + 0.5 - point.x,
                                            static_cast<double>(row) + 0.5 - point.y);
                const double covered = size > 1.0 ? std::clamp(size / 2.0 + 0.5 - d, 0.0, 1.0) : 1.0;
                PixelShade& sum = sums[static_cast<std::size_t>(row * plan.width + column)];
                sum.weight += static_cast<float>(covered);
                sum.level += static_cast<float>(covered * level);
            }
        }
    }
    return sums;
}

TEST_P(CpuPointsTest, CellsTellTheLevelsOfDensities) {
    const std::string all = "'camera': {'eye': [2, 4, 8], 'target': [0, 0, 0]}";
    for (const double size : {1.0, 3.0}) {
        const std::string look = size > 1.0 ? ", 'opacity': 0.000001, 'sizePixels': 3" : ", 'opacity': 0.01";
        SelectionCache selections;
        const auto expect = [&](FramePlan plan, const FramePlan& plain, From from, double more,
                                const char* what) {
            shadePoints(plan.points[0], shade);
            const auto shades = gather(plan, from).shades;
            const auto expected = plainShades(plain, size);
            ASSERT_EQ(shades.size(), expected.size());
            double weight = 0.0, level = 0.0, sum = 0.0, levels = 0.0;
            for (std::size_t i = 0; i < expected.size(); ++i) {
                weight += std::abs(double{shades[i].weight} - double{expected[i].weight});
                level += std::abs(double{shades[i].level} - double{expected[i].level});
                sum += double{expected[i].weight};
                levels += double{expected[i].level};
            }
            EXPECT_GT(levels, 10.0 * sum) << "some of them are above the least";
            EXPECT_LT(levels, 245.0 * sum) << "and below the greatest";
            EXPECT_LE(weight, 4.0 + more * sum) << what << size;
            EXPECT_LE(level, 255.0 * (4.0 + more * sum)) << what << size;
        };
        for (const auto* camera : cameras) {
            const auto plan = makeFramePlan(scene(camera, look), Quality::exact());
            expect(plan, plan, From::leaves, 2e-3, camera);
            expect(plan, plan, From::groups, 2e-3, camera);
        }
        const auto whole = scene(all, look);
        expect(makeFramePlan(whole, {.slabs = 24}), makeFramePlan(whole, Quality::exact()), From::leaves,
               0.015, "stream");
        const Quality quality{.pointFraction = 0.2, .slabs = 24};
        const auto preview = makeFramePlan(whole, quality, selections, {.preview = true});
        ASSERT_NE(preview.points[0].preview, nullptr);
        // Up to a block more than the share.
        expect(preview, makeFramePlan(whole, quality, selections, {}), From::leaves, 0.6, "preview");
        auto previewColors = preview;
        shadePoints(previewColors.points[0], shade);
        const auto shades = gather(previewColors).shades;
        const auto levels = std::accumulate(
            shades.begin(), shades.end(), PixelShade{0.0F, 0.0F}, [](PixelShade sum, const PixelShade& each) {
                return PixelShade{sum.weight + each.weight, sum.level + each.level};
            });
        const auto exact = plainShades(makeFramePlan(whole, quality, selections, {}), 1.0);
        double weight = 0.0, level = 0.0;
        for (const auto& each : exact) {
            weight += double{each.weight};
            level += double{each.level};
        }
        EXPECT_NEAR(double{levels.level} / double{levels.weight}, level / weight, 2.0) << "preview" << size;
    }
}

TEST_P(CpuPointsTest, ATileBoxHoldsAllThatItsLeafTouches) {
    for (const auto* camera : cameras) {
        const auto plan = makeFramePlan(scene(camera), Quality::exact());
        const PointsPlan& layer = plan.points[0];
        LeafCells leafCells;
        const auto cells = leafCells.upTo(*layer.step, layer.step->leaves().size());
        const PointMap map = PointMap::make(plan, layer);
        std::vector<TileBox> boxes(cells.size());
        leafTiles(map, cells.data(), cells.size(), 0.0F, boxes.data());
        const auto leaves = layer.step->leaves();
        for (std::size_t i = 0; i < cells.size(); ++i) {
            std::vector<ScreenPoint> screen(leaves.pointCount[i]);
            const auto positions = layer.step->positions(leaves.pointBegin[i], leaves.pointCount[i]);
            const auto all = layer.step->positions(0, layer.step->pointCount());
            const std::size_t hits = projectPoints(map, cells[i], positions.data(), positions.size(),
                                                   all.data() + all.size(), 0.0F, screen.data());
            for (std::size_t k = 0; k < hits; ++k) {
                const double column = std::min<double>(screen[k].x, plan.width - 1) / Tile::edge;
                const double row = std::min<double>(screen[k].y, plan.height - 1) / Tile::edge;
                EXPECT_TRUE(column >= boxes[i].left && column < boxes[i].right && row >= boxes[i].top &&
                            row < boxes[i].bottom)
                    << camera << ", leaf " << i;
            }
        }
    }
}

/// The kernels are compiled for vectors only.
std::vector<std::int64_t> vectorTargets() {
    auto targets = hwy::SupportedAndGeneratedTargets();
    std::erase_if(targets, [](std::int64_t target) { return target == HWY_SCALAR; });
    return targets;
}

INSTANTIATE_TEST_SUITE_P(All, CpuPointsTest, testing::ValuesIn(vectorTargets()),
                         [](const auto& target) { return std::string(hwy::TargetName(target.param)); });

TEST(CpuPoints, EveryKindOfVectorsCountsTheSame) {
    const auto targets = vectorTargets();
    for (const auto* camera : cameras) {
        const auto plan = makeFramePlan(scene(camera, faint), {.slabs = 24});
        hwy::SetSupportedTargetsForTest(targets.front());
        const auto flat = flatCounts(plan);
        const auto gathered = gather(plan), grouped = gather(plan, From::groups);
        for (const std::int64_t target : targets) {
            hwy::SetSupportedTargetsForTest(target);
            EXPECT_EQ(flatCounts(plan), flat) << camera << ", " << hwy::TargetName(target);
            EXPECT_EQ(gather(plan).weight, gathered.weight) << camera << ", " << hwy::TargetName(target);
            EXPECT_EQ(gather(plan, From::groups).weight, grouped.weight)
                << camera << ", " << hwy::TargetName(target);
        }
    }
    hwy::SetSupportedTargetsForTest(0);
}

/// The cells of a tile, and the shades of its pixels if there are any, after two runs of discs.
std::vector<float> cellsOfDiscs(double size, bool shaded) {
    const auto places = somePlaces();
    const DiscFootprint disc(size, 0.8);
    TileCells cells(3, 0, shaded);
    gatherScreenDiscs(places.data(), places.size(), disc, {1, 0}, cells);
    gatherScreenDiscs(places.data(), places.size() / 2 + 5, disc, {1, 0}, cells);
    cells.settle();
    std::vector<float> sums;
    for (std::size_t i = 0; i < std::size_t{3} * Tile::pixels; ++i)
        sums.insert(sums.end(), {cells.cells()[i].weight, cells.cells()[i].depth});
    for (std::size_t i = 0; shaded && i < Tile::pixels; ++i)
        sums.insert(sums.end(), {cells.shades()[i].weight, cells.shades()[i].level});
    for (std::uint32_t slab = 0; slab < 3; ++slab) {
        for (std::uint32_t packet = 0; packet < Tile::packets; ++packet)
            sums.push_back((cells.occupied(slab) >> packet & 1) != 0 ? 1.0F : 0.0F);
    }
    return sums;
}

// They are added in their order, so that wider vectors change no byte of a picture.
TEST(CpuPoints, DiscsAddUpAlikeInFusedVectorsOfAnyWidth) {
    std::vector<std::int64_t> fused = vectorTargets();
    std::erase_if(fused, [](std::int64_t target) { return target > HWY_AVX2; });
    for (const double size : {1.5, 3.0, 8.0, 40.0}) {
        for (const bool shaded : {false, true}) {
            std::vector<float> first;
            for (const std::int64_t target : fused) {
                hwy::SetSupportedTargetsForTest(target);
                const auto sums = cellsOfDiscs(size, shaded);
                if (first.empty()) first = sums;
                EXPECT_EQ(sums, first) << size << ", " << hwy::TargetName(target);
            }
        }
    }
    hwy::SetSupportedTargetsForTest(0);
}

TEST(CpuPoints, AnyNumberOfThreadsCountsTheSame) {
    const auto plan = makeFramePlan(scene(cameras[1]), {.slabs = 24});
    const auto discs = makeFramePlan(scene(cameras[0], ", 'sizePixels': 3"), {.slabs = 24});
    tbb::task_arena one(1), four(4);
    for (const auto& each : {plan, discs}) {
        EXPECT_EQ(one.execute([&] { return pictureOf(each, flatPoints(each)); }),
                  four.execute([&] { return pictureOf(each, flatPoints(each)); }));
        for (const From from : {From::leaves, From::groups}) {
            EXPECT_EQ(one.execute([&] { return gather(each, from).weight; }),
                      four.execute([&] { return gather(each, from).weight; }));
        }
    }
}

TEST(CpuPoints, AStoppedPictureSaysSo) {
    const auto plan = makeFramePlan(scene(cameras[0]), {.slabs = 24});
    std::stop_source source;
    source.request_stop();
    LeafCells cells;
    const auto& layer = plan.points[0];
    const auto span = cells.upTo(*layer.step, layer.selection->drawn.size());
    EXPECT_FALSE(FlatPoints().draw(plan, layer, span, nullptr, PixelFormat::srgb8, source.get_token()));
    EXPECT_FALSE(TilePoints().sort(plan, layer, span, nullptr, nullptr, source.get_token()));
    EXPECT_EQ(groupPoints(layer, span, source.get_token()), nullptr);
}

using Places = std::vector<std::array<double, 3>>;

/// The places of a layer's points in its box, in order.
Places boxPlaces(const PointsPlan& layer) {
    const auto leaves = layer.step->leaves();
    const auto nodes = layer.step->nodes();
    Places places;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const double edge = std::ldexp(1.0, -nodes.level[leaves.node[i]]);
        const glm::dvec3 cell(cellPlace(nodes.morton[leaves.node[i]]));
        for (const auto& p : layer.step->positions(leaves.pointBegin[i], layer.drawn(i))) {
            const glm::dvec3 at = edge * (cell + (glm::dvec3(p.x, p.y, p.z) + 0.5) / 65536.0);
            places.push_back({at.x, at.y, at.z});
        }
    }
    std::sort(places.begin(), places.end());
    return places;
}

/// Those that groups tell.
Places boxPlaces(const PointGroups& groups) {
    Places places;
    for (const LeafPoints& group : groups.groups) {
        const double edge = std::ldexp(1.0, -static_cast<int>(cellLevel(group.cell)));
        const glm::dvec3 cell(cellX(group.cell), cellY(group.cell), cellZ(group.cell));
        for (std::uint32_t i = 0; i < group.count(); ++i) {
            const GroupedPoint& p = groups.points[group.begin() + i];
            const glm::uvec3 step(p.low & 0x1fffff, p.low >> 21 | (p.high & 0x3ff) << 11, p.high >> 11);
            const glm::dvec3 at = edge * (cell + glm::dvec3(step) / 2097152.0);
            places.push_back({at.x, at.y, at.z});
        }
    }
    std::sort(places.begin(), places.end());
    return places;
}

TEST(PointGroups, TellEachPointOnceAndExactly) {
    // Leaves of a point are as deep as they may be; of many there are more than a run has.
    const auto beam = test::beam({.core = 30000, .halo = 6000, .filaments = 2000});
    for (const std::uint32_t capacity : {1U, 24U, 20000U}) {
        auto drawn = scene(cameras[0]);
        drawn.layers[0].step = test::MemoryStep::make(beam, {.leafCapacity = capacity});
        const auto plan = makeFramePlan(drawn, Quality::exact());
        LeafCells cells;
        const auto& layer = plan.points[0];
        const auto groups = groupPoints(layer, cells.upTo(*layer.step, layer.selection->drawn.size()), {});
        EXPECT_EQ(boxPlaces(*groups), boxPlaces(layer)) << capacity;
        EXPECT_GE(groups->points.size(), layer.selection->points + sparePoints);
        // Few leaves lie so far from others that they are alone.
        if (capacity < 100) {
            EXPECT_LT(groups->groups.size(), layer.step->leaves().size()) << capacity;
        }
    }
}

TEST(PointGroups, AreMadeOnceForASelection) {
    const auto plan = makeFramePlan(scene(cameras[0]), Quality::exact());
    auto other = plan;
    other.points[0].selection = std::make_shared<const PointSelection>(*plan.points[0].selection);
    LeafCells cells;
    ResidentGroups groups;
    const auto& layer = plan.points[0];
    const auto span = cells.upTo(*layer.step, layer.selection->drawn.size());
    const auto first = groups.of(layer, span, {});
    EXPECT_EQ(groups.of(layer, span, {}), first);
    EXPECT_NE(groups.of(other.points[0], span, {}), first);
    EXPECT_EQ(groups.of(layer, span, {}), first);
    std::weak_ptr<const PointGroups> kept = groups.of(other.points[0], span, {});
    other.points[0].selection = nullptr;
    groups.dropExpired();
    EXPECT_TRUE(kept.expired());
}

TEST(PointGroups, TellLevels) {
    auto plan = makeFramePlan(scene(cameras[0]), Quality::exact());
    LeafCells cells;
    ResidentGroups groups;
    auto& layer = plan.points[0];
    const auto span = cells.upTo(*layer.step, layer.selection->drawn.size());
    const auto plain = groups.of(layer, span, {});
    EXPECT_TRUE(plain->levels.empty());
    shadePoints(layer, shade);
    const auto shaded = groups.of(layer, span, {});
    EXPECT_EQ(shaded->levels.size(), shaded->points.size());
    EXPECT_GT(*std::max_element(shaded->levels.begin(), shaded->levels.end()), 100);
    auto other = layer;
    shadePoints(other, {{0.3, 3.0}, shade.colors});
    EXPECT_NE(groups.of(other, span, {})->levels, shaded->levels);
    EXPECT_EQ(groups.of(layer, span, {}), shaded);
}

TEST(PointGroups, ServeWhatRestsAndIsNotTooNear) {
    const auto serve = [](const FramePlan& plan) {
        return PointGroups::serve(plan, plan.points[0], PointMap::make(plan, plan.points[0]));
    };
    EXPECT_TRUE(serve(makeFramePlan(scene(cameras[4]), Quality::exact())));
    EXPECT_FALSE(serve(makeFramePlan(scene(cameras[4]), {.slabs = 24})));
    // From within the box.
    EXPECT_FALSE(serve(makeFramePlan(scene(cameras[1]), Quality::exact())));
    auto weighed = makeFramePlan(scene(cameras[4]), Quality::exact());
    auto selection = *weighed.points[0].selection;
    selection.weights.resize(selection.drawn.size());
    weighed.points[0].selection = std::make_shared<const PointSelection>(std::move(selection));
    EXPECT_FALSE(serve(weighed));
}

TEST(DiscFootprint, CoversAsDefined) {
    const double size = 5.0, opacity = 0.4;
    const DiscFootprint disc(size, opacity);
    std::vector<double> weights(20 * 20, 0.0);
    const float x = 9.3F, y = 10.8F;
    disc.spread(x, y, {0, 0, 20, 20}, [&](std::int32_t column, std::int32_t row, float weight) {
        weights[static_cast<std::size_t>(row * 20 + column)] += weight;
    });
    for (int row = 0; row < 20; ++row) {
        for (int column = 0; column < 20; ++column) {
            const double d = std::hypot(column + 0.5 - x, row + 0.5 - y);
            const double coverage = std::clamp(size / 2.0 + 0.5 - d, 0.0, 1.0);
            const double expected = std::log1p(-opacity * coverage) / std::log1p(-opacity);
            // Coverage is told to a 1024th; the slope of the weight by coverage is at most 1.31 here.
            EXPECT_NEAR(weights[static_cast<std::size_t>(row * 20 + column)], expected, 1.31 / 2048 + 1e-5);
        }
    }
}

}  // namespace
}  // namespace mote::render
