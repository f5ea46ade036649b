// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "server/render/layers/stipple/dot_cells.h"
#include "server/render/layers/stipple/pixel_map.h"
#include "server/render/layers/stipple/replay.h"
#include "server/render/layers/stipple/tone.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::render {
namespace {

using test::smallHierarchy;

TEST(StippleReplay, AUniformShareDrawsThatManyPointsInTheOrderOfRemoval) {
    const StippleReplay replay(smallHierarchy());
    const auto count = [&](float share) {
        const auto drawn = replay.select(std::vector<float>(5, share));
        // Who is drawn is removed after everybody who is not.
        for (std::size_t i = 0; i < 5; ++i) {
            for (std::size_t j = 0; j < 5; ++j) {
                EXPECT_TRUE(drawn[i] == 0 || drawn[j] != 0 || replay.removal(i) > replay.removal(j));
            }
        }
        return std::accumulate(drawn.begin(), drawn.end(), 0);
    };
    for (int n = 0; n <= 5; ++n) EXPECT_EQ(count(static_cast<float>(n) / 5.0F), n);
    EXPECT_EQ(count(0.09F), 0);  // rounds to none and to one
    EXPECT_EQ(count(0.11F), 1);
    EXPECT_EQ(count(7.0F), 5);
    EXPECT_EQ(count(-1.0F), 0);
    EXPECT_EQ(count(std::numeric_limits<float>::quiet_NaN()), 0);
    EXPECT_EQ(count(std::numeric_limits<float>::infinity()), 5);
}

/// Positions are kept to within this in every hierarchy of these tests: see PackedMoves::error.
constexpr float tolerance = 0.01F;

void expectAt(const glm::vec3& is, const glm::vec3& should) {
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(is[d], should[d], tolerance) << d;
}

TEST(StippleReplay, AMoveIsMadeOnlyWhenAllBeforeItAre) {
    const StippleReplay replay(smallHierarchy());
    for (std::uint32_t left = 1; left <= 5; ++left) EXPECT_LT(replay.moves().error(left), tolerance);
    const auto at = [&](std::vector<std::uint8_t> drawn, std::size_t point) {
        return replay.placed(point, drawn);
    };
    EXPECT_EQ(at({1, 1, 1, 1, 1}, 1), replay.position(1));
    expectAt(at({1, 1, 0, 1, 1}, 1), {0.4F, 0, 0});
    expectAt(at({0, 1, 0, 1, 1}, 1), {0.4F, 0.1F, 0});
    expectAt(at({0, 1, 0, 1, 0}, 1), {0.5F, 0.1F, 0});
    // Out of the order of removal: 4 is gone and 0 is not, so the move for 4 waits.
    expectAt(at({1, 1, 0, 1, 0}, 1), {0.4F, 0, 0});
    EXPECT_EQ(at({0, 1, 1, 1, 0}, 1), replay.position(1));
    expectAt(at({0, 0, 0, 1, 0}, 3), {0.6F, 0.1F, 0});
    EXPECT_EQ(at({0, 0, 0, 0, 1}, 4), replay.position(4));
}

TEST(StippleReplay, PlacesTheDrawnInTheirOrder) {
    const StippleReplay replay(smallHierarchy());
    const std::vector<std::uint8_t> drawn{0, 1, 0, 1, 0};
    const auto points = replay.place(drawn);
    ASSERT_EQ(points.size(), 2U);
    EXPECT_EQ(points[0].point, 1U);
    expectAt(points[0].position, {0.5F, 0.1F, 0});
    EXPECT_EQ(points[1].point, 3U);
    expectAt(points[1].position, {0.6F, 0, 0});
    EXPECT_TRUE(replay.place(std::vector<std::uint8_t>(5, 0)).empty());
}

/// A hierarchy in space of random moves about as long as the distance of the points that are left, a few of
/// them a hundred times as long, over more points than lie in a block.
storage::StippleHierarchy wild() {
    constexpr std::uint32_t points = 9000;
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    const auto vector = [&](float length) {
        return length * glm::vec3(normal(random), normal(random), normal(random));
    };
    storage::StippleHierarchy h;
    h.removal.resize(points);
    std::iota(h.removal.begin(), h.removal.end(), 0U);
    std::shuffle(h.removal.begin(), h.removal.end(), random);
    std::vector<std::uint32_t> order(points);
    for (std::uint32_t i = 0; i < points; ++i) order[h.removal[i]] = i;
    h.movesBegin.push_back(0);
    for (std::uint32_t i = 0; i < points; ++i) {
        auto at = h.positions.emplace_back(vector(1.0F));
        h.normals.push_back(glm::normalize(vector(1.0F)));
        for (std::uint32_t removal = random() % 4000; removal < h.removal[i];
             removal += 1 + random() % 4000) {
            const float distance = 1.0F / std::sqrt(static_cast<float>(points - removal));
            at += vector(random() % 50 == 0 ? 100.0F * distance : distance);
            h.moveNeighbour.push_back(order[removal]);
            h.movePosition.push_back(at);
        }
        h.movesBegin.push_back(h.moveNeighbour.size());
    }
    h.deathArea.assign(points, 1.0F);
    h.locked.assign(points, 0);
    return h;
}

TEST(PackedMoves, KeepNeighboursExactlyAndPlacesClosely) {
    const auto h = wild();
    ASSERT_TRUE(storage::checkHierarchy(h).ok());
    const PackedMoves packed(h);
    for (std::size_t i = 0; i < h.size(); ++i) {
        auto walk = packed.walk(i, h.positions[i]);
        for (auto m = h.movesBegin[i]; m < h.movesBegin[i + 1]; ++m) {
            const auto removal = walk.next();
            ASSERT_TRUE(removal);
            ASSERT_EQ(*removal, h.removal[h.moveNeighbour[m]]);
            walk.make();
            // Sums of floats of order 10 besides.
            const float error = packed.error(static_cast<std::uint32_t>(h.size()) - *removal) + 1e-5F;
            for (int d = 0; d < 3; ++d) ASSERT_NEAR(walk.position()[d], h.movePosition[m][d], error);
        }
        ASSERT_FALSE(walk.next());
    }
}

/// P points without geometry; each moves when each of the eight before it in removal goes.
storage::StippleHierarchy chain(std::uint32_t points) {
    storage::StippleHierarchy h;
    h.movesBegin.push_back(0);
    for (std::uint32_t i = 0; i < points; ++i) {
        h.positions.push_back({static_cast<float>(i), 0, 0});
        h.removal.push_back(i);
        for (std::uint32_t n = i < 8 ? 0 : i - 8; n < i; ++n) {
            h.moveNeighbour.push_back(n);
            h.movePosition.push_back({static_cast<float>(i), static_cast<float>(n), 1});
        }
        h.movesBegin.push_back(h.moveNeighbour.size());
    }
    h.normals.assign(points, {0, 0, 1});
    h.deathArea.assign(points, 1.0F);
    h.locked.assign(points, 0);
    return h;
}

TEST(StippleReplay, ThreadsChangeNothing) {
    constexpr std::uint32_t points = 50000;
    const StippleReplay replay(chain(points));
    std::mt19937 random(1);
    std::vector<float> shares(points);
    for (auto& share : shares) share = static_cast<float>(random()) / 4294967296.0F;
    const auto run = [&](int threads) {
        tbb::task_arena arena(threads);
        return arena.execute([&] { return replay.place(replay.select(shares)); });
    };
    const auto one = run(1);
    const auto four = run(4);
    ASSERT_EQ(one.size(), four.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
        ASSERT_EQ(one[i].point, four[i].point);
        ASSERT_EQ(one[i].position, four[i].position);
    }
}

TEST(Tone, coverAndInkAreInverse) {
    double before = -1.0;
    for (double ink = 0.0; ink <= 1.0; ink += 0.001) {
        const double cover = coverOfInk(ink);
        EXPECT_GT(cover, before);
        before = cover;
        EXPECT_NEAR(inkOfCover(cover), ink, 1e-12);
        EXPECT_GE(cover, ink - 1e-12);  // dots cannot ink more than they cover
    }
    EXPECT_EQ(inkOfCover(solidCover), 1.0);
    EXPECT_EQ(inkOfCover(100.0), 1.0);
    EXPECT_EQ(coverOfInk(1.0), solidCover);
    EXPECT_EQ(inkOfCover(0.0), 0.0);
}

TEST(Tone, dotsThatDoNotMeetInkTheirAreas) {
    EXPECT_NEAR(densityOfInk(0.25, 4.0), 0.25 / (std::numbers::pi * 4.0), 1e-12);
}

/// A hexagonal cell of points a apart has the area sqrt(3) / 2 a^2.
TEST(Tone, densityOfASpacing) {
    EXPECT_NEAR(1.0 / densityOfSpacing(2.0), std::sqrt(3.0) / 2.0 * 4.0, 1e-12);
}

PixelMap halves() {
    return {2, 1, {0.0F, 1.0F}};
}

TEST(PhotographTone, blackGetsTheFullDensityAndWhiteNone) {
    const PhotographTone tone{10.0, 2.0, 1.0, true};
    const auto wanted = wantedDensity(halves(), 200, 100, tone);
    EXPECT_FLOAT_EQ(wanted.at(10, 50), static_cast<float>(tone.fullDensity()));
    EXPECT_EQ(wanted.at(190, 50), 0.0F);
    const auto inverted = wantedDensity(halves(), 200, 100, {10.0, 2.0, 1.0, false});
    EXPECT_EQ(inverted.at(10, 50), 0.0F);
    EXPECT_FLOAT_EQ(inverted.at(190, 50), static_cast<float>(tone.fullDensity()));
}

TEST(PhotographTone, inkIsOneMinusBrightness) {
    const PixelMap grey(1, 1, {0.25F});
    for (const double gamma : {0.5, 1.0, 2.0}) {
        const PhotographTone tone{10.0, 2.0, gamma, true};
        const double share = 1.0 - std::pow(0.25, gamma);
        EXPECT_NEAR(wantedDensity(grey, 10, 10, tone).at(5, 5), share * tone.fullDensity(), 1e-6);
    }
}

TEST(PhotographTone, thePictureLiesInTheMiddle) {
    const PixelMap black(2, 1, {0.0F, 0.0F});
    const auto wanted = wantedDensity(black, 100, 100, {10.0, 2.0, 1.0, true});
    EXPECT_EQ(wanted.at(50, 24), 0.0F);
    EXPECT_GT(wanted.at(50, 25), 0.0F);
    EXPECT_GT(wanted.at(50, 74), 0.0F);
    EXPECT_EQ(wanted.at(50, 75), 0.0F);
}

constexpr std::uint32_t width = 37, height = 23;

std::vector<float> randomValues() {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    std::vector<float> values(width * height);
    for (auto& value : values) value = unit(random);
    return values;
}

/// The mean over a rectangle, pixel by pixel.
double slowMean(const std::vector<float>& values, double x0, double y0, double x1, double y1) {
    double sum = 0.0;
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const double across = std::min(x1, x + 1.0) - std::max<double>(x0, x);
            const double down = std::min(y1, y + 1.0) - std::max<double>(y0, y);
            if (across > 0.0 && down > 0.0) sum += across * down * values[y * width + x];
        }
    }
    return sum / ((x1 - x0) * (y1 - y0));
}

TEST(PixelMap, meansOverSquaresAreExact) {
    const auto values = randomValues();
    const PixelMap map(width, height, values);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 500; ++i) {
        const double x = unit(random) * width;
        const double y = unit(random) * height;
        const double half = 0.5 * (1.0 + 12.0 * unit(random));
        const double expected =
            slowMean(values, std::max(x - half, 0.0), std::max(y - half, 0.0),
                     std::min<double>(x + half, width), std::min<double>(y + half, height));
        // Sums up to 851 in doubles, of which a part of a pixel is the least that is looked at.
        EXPECT_NEAR(map.mean(x, y, 2.0 * half), expected, 1e-9);
    }
    EXPECT_NEAR(map.total(), slowMean(values, 0, 0, width, height) * width * height, 1e-9);
}

TEST(PixelMap, outsideIsAsAtTheEdge) {
    const PixelMap map(width, height, randomValues());
    EXPECT_EQ(map.mean(-50.0, 7.5, 1.0), map.mean(0.0, 7.5, 1.0));
    EXPECT_EQ(map.mean(1e6, 1e6, 3.0), map.mean(width, height, 3.0));
    EXPECT_NEAR(map.mean(10.0, 10.0, 1e6), map.total() / (width * height), 1e-12);
}

TEST(PixelMap, ofOnePixel) {
    const PixelMap map(1, 1, {0.25F});
    EXPECT_DOUBLE_EQ(map.mean(0.5, 0.5, 0.1), 0.25);
    EXPECT_DOUBLE_EQ(map.mean(-3.0, 9.0, 100.0), 0.25);
}

PixelMap randomMap(std::uint32_t width, std::uint32_t height) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0.0F, 0.1F);
    std::vector<float> values(std::size_t{width} * height);
    for (auto& value : values) value = unit(random);
    return {width, height, std::move(values)};
}

std::vector<glm::vec2> randomDots(std::size_t count, float width, float height) {
    std::mt19937 random(9);
    std::uniform_real_distribution<float> unit(-0.05F, 1.05F);  // some lie outside
    std::vector<glm::vec2> dots(count);
    for (auto& dot : dots) dot = {unit(random) * width, unit(random) * height};
    return dots;
}

/// Pixel by pixel, over all dots.
std::vector<DotCell> slowCells(const PixelMap& wanted, const std::vector<glm::vec2>& dots) {
    std::vector<DotCell> cells(dots.size());
    for (std::size_t y = 0; y < wanted.height(); ++y) {
        for (std::size_t x = 0; x < wanted.width(); ++x) {
            const glm::dvec2 pixel(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
            std::size_t nearest = 0;
            for (std::size_t i = 1; i < dots.size(); ++i) {
                if (glm::distance(pixel, glm::dvec2(dots[i])) <
                    glm::distance(pixel, glm::dvec2(dots[nearest]))) {
                    nearest = i;
                }
            }
            cells[nearest].mass += wanted.at(x, y);
            cells[nearest].centroid += static_cast<double>(wanted.at(x, y)) * pixel;
        }
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
        auto& cell = cells[i];
        cell.centroid = cell.mass > 0.0 ? cell.centroid / cell.mass : glm::dvec2(dots[i]);
    }
    return cells;
}

void expectSameAsSlow(const PixelMap& wanted, const std::vector<glm::vec2>& dots) {
    const auto cells = dotCells(wanted, dots);
    const auto expected = slowCells(wanted, dots);
    for (std::size_t i = 0; i < dots.size(); ++i) {
        // Sums in single precision of at most some 10^4 pixels of a block; a pixel between two dots may be
        // either's, where single and double precision disagree: none is, for these seeds.
        EXPECT_NEAR(cells[i].mass, expected[i].mass, 1e-4 * (1.0 + expected[i].mass)) << i;
        EXPECT_NEAR(cells[i].centroid.x, expected[i].centroid.x, 2e-3) << i;
        EXPECT_NEAR(cells[i].centroid.y, expected[i].centroid.y, 2e-3) << i;
    }
}

TEST(DotCells, areVoronoiCells) {
    expectSameAsSlow(randomMap(131, 77), randomDots(300, 131, 77));
    expectSameAsSlow(randomMap(200, 90), randomDots(3, 200, 90));
    expectSameAsSlow(randomMap(64, 64), randomDots(1, 64, 64));
}

TEST(DotCells, secondMomentsOfARectangle) {
    const PixelMap map(24, 12, std::vector<float>(24 * 12, 0.5F));
    const auto cell = dotCells(map, std::vector<glm::vec2>{{3.0F, 4.0F}}).at(0);
    EXPECT_NEAR(cell.mass, 144.0, 1e-3);
    // Of n pixels' centres in a row: (n^2 - 1) / 12.
    EXPECT_NEAR(cell.xx, (24.0 * 24.0 - 1.0) / 12.0, 1e-2);
    EXPECT_NEAR(cell.yy, (12.0 * 12.0 - 1.0) / 12.0, 1e-2);
    EXPECT_NEAR(cell.xy, 0.0, 1e-2);
}

TEST(DotCells, noDotsAndFarDots) {
    const auto map = randomMap(50, 50);
    EXPECT_TRUE(dotCells(map, {}).empty());
    const auto cells = dotCells(map, std::vector<glm::vec2>{{-1e6F, -1e6F}});
    EXPECT_NEAR(cells.at(0).mass, map.total(), 1e-3);
}

TEST(DotCells, sameOnAnyThreads) {
    const auto map = randomMap(400, 300);
    const auto dots = randomDots(2000, 400, 300);
    const auto all = dotCells(map, dots);
    tbb::task_arena one(1);
    const auto alone = one.execute([&] { return dotCells(map, dots); });
    for (std::size_t i = 0; i < dots.size(); ++i) {
        EXPECT_EQ(all[i].mass, alone[i].mass);
        EXPECT_EQ(all[i].centroid, alone[i].centroid);
    }
}

}  // namespace
}  // namespace mote::render
