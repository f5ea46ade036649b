// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines cut by a grid, tones blurred and taken between cells, and blurs that stop at steps in depth.
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "server/render/ink/complexity.h"
#include "server/render/ink/raster.h"
#include "server/render/ink/tone_grid.h"
#include "server/render/layers/ink/density_grid.h"
#include "storage/storage_error.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/random.h"

namespace mote::render {
namespace {

constexpr std::uint32_t columns = 13, rows = 7;

/// Of a line within a box (Liang and Barsky 1984).
double clippedLength(const glm::dvec2& from, const glm::dvec2& to) {
    double begin = 0.0, end = 1.0;
    for (int axis = 0; axis < 2; ++axis) {
        const double most = axis == 0 ? columns : rows, way = to[axis] - from[axis];
        if (way == 0.0 && (from[axis] < 0.0 || from[axis] > most)) return 0.0;
        if (way == 0.0) continue;
        begin = std::max(begin, std::min(-from[axis] / way, (most - from[axis]) / way));
        end = std::min(end, std::max(-from[axis] / way, (most - from[axis]) / way));
    }
    return std::max(0.0, end - begin) * glm::distance(from, to);
}

void expectAddsUp(const glm::dvec2& from, const glm::dvec2& to, double error) {
    double sum = 0.0;
    int squares = 0;
    eachSquare(from, to, columns, rows, [&](std::uint32_t column, std::uint32_t row, double length) {
        EXPECT_LT(column, columns);
        EXPECT_LT(row, rows);
        EXPECT_GE(length, 0.0);
        EXPECT_LE(length, std::numbers::sqrt2 + error);
        sum += length;
        ++squares;
    });
    EXPECT_NEAR(sum, clippedLength(from, to), error) << from.x << ' ' << from.y << ' ' << to.x << ' ' << to.y;
    EXPECT_LE(squares, static_cast<int>(columns + rows));
}

TEST(EachSquare, AddsUpToTheLineInsideTheGrid) {
    test::Random random(1);
    const auto any = [&] { return random.between(-6.0, 20.0); };
    for (int i = 0; i < 20000; ++i) {
        glm::dvec2 from(any(), any()), to(any(), any());
        // Along sides and diagonals of squares, too.
        if (i % 4 == 1) from = glm::round(from);
        if (i % 8 == 1) to = glm::round(to);
        if (i % 5 == 0) to.x = from.x;
        if (i % 7 == 0) to.y = from.y;
        expectAddsUp(from, to, 1e-9);
    }
}

TEST(EachSquare, FarPlacesDoNoHarm) {
    test::Random random(2);
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec2 middle(random.between(-2.0, 15.0), random.between(-2.0, 9.0));
        const double angle = random.between(0.0, 6.3);
        const glm::dvec2 way = random.magnitude(10, 30) * glm::dvec2(std::cos(angle), std::sin(angle));
        expectAddsUp(middle - way, middle + way, 1e-4);
        expectAddsUp(middle, middle + way, 1e-4);
    }
    const double nothing = std::nan("");
    eachSquare({nothing, 0.0}, {1.0, 1.0}, columns, rows, [](auto, auto, double) { FAIL(); });
}

TEST(EachSquare, LengthsAreThoseInEachSquare) {
    Raster<double> lengths(columns, rows);
    eachSquare(
        {0.5, 0.5}, {3.5, 0.5}, columns, rows,
        [&](std::uint32_t column, std::uint32_t row, double length) { lengths.at(column, row) += length; });
    EXPECT_NEAR(lengths.at(0, 0), 0.5, 1e-12);
    EXPECT_NEAR(lengths.at(1, 0), 1.0, 1e-12);
    EXPECT_NEAR(lengths.at(2, 0), 1.0, 1e-12);
    EXPECT_NEAR(lengths.at(3, 0), 0.5, 1e-12);
}

TEST(ToneGrid, ABlurKeepsWhatIsEvenAndTheSum) {
    for (const double deviation : {0.5, 1.0, 3.0, 40.0, 256.0}) {
        for (const float value : blurred(ToneGrid(20, 15, 0.7F), deviation).values)
            EXPECT_NEAR(value, 0.7F, 1e-5F);
    }
    ToneGrid drop(41, 31);
    drop.at(20, 15) = 1.0F;
    const auto made = blurred(drop, 3.0);
    EXPECT_NEAR(std::accumulate(made.values.begin(), made.values.end(), 0.0), 1.0, 1e-5);
    EXPECT_NEAR(made.at(20, 15), 1.0 / (2.0 * std::numbers::pi * 9.0), 5e-4);
    EXPECT_EQ(made.at(23, 15), made.at(20, 18));
    EXPECT_NEAR(made.at(23, 15) / made.at(20, 15), std::exp(-0.5), 1e-4);
}

TEST(ToneGrid, MeansAndPlacesFitAnySize) {
    test::Random random(3);
    for (int i = 0; i < 60; ++i) {
        const auto width = static_cast<std::uint32_t>(1 + random.below(50));
        const auto height = static_cast<std::uint32_t>(1 + random.below(50));
        const ToneCells cells(width, height, random.oneOf({1.0, 3.0, 6.0, 20.0, 256.0}));
        EXPECT_LE(3.0 * cells.pixels, std::max(3.0, 3.0 * cells.blur * cells.pixels));
        // A ramp stays one, but for cells that the picture's side cuts.
        Raster<float> picture(width, height);
        for (std::uint32_t row = 0; row < height; ++row) {
            for (std::uint32_t column = 0; column < width; ++column)
                picture.at(column, row) = static_cast<float>(column) + 0.5F;
        }
        const auto grid = meansOf(picture, cells);
        const double half = 0.5 * cells.pixels, whole = width - width % cells.pixels;
        for (double x = half; x < whole - half; x += 0.37)
            EXPECT_NEAR(toneAt(grid, cells, {x, 0.5 * height}), x, 1e-3);
        for (const double place : {-1e30, -1.0, 0.0, 1e30, std::nan("")}) {
            const float tone = toneAt(grid, cells, {place, place});
            if (!std::isnan(place)) {
                EXPECT_TRUE(tone >= 0.0F && tone <= static_cast<float>(width));
            }
        }
        EXPECT_EQ(toneAt(grid, cells, {-5.0, -5.0}), grid.at(0, 0));
        EXPECT_EQ(toneAt(grid, cells, {1e9, 1e9}), grid.values.back());
    }
}

TEST(Complexity, ABlurStopsAtSteps) {
    test::Random random(4);
    for (int i = 0; i < 30; ++i) {
        const auto step = static_cast<std::uint32_t>(1 + random.below(30));
        Raster<float> depth(32, 24, 1.0F), picture(32, 24, 0.25F);
        for (std::uint32_t row = 0; row < 24; ++row) {
            for (std::uint32_t column = step; column < 32; ++column) {
                depth.at(column, row) = i % 2 == 0 ? 1.2F : HUGE_VALF;
                picture.at(column, row) = 0.75F;
            }
        }
        const auto made = blurredWithin(picture, depth, 1.0, random.between(1.0, 50.0));
        for (std::size_t k = 0; k < made.values.size(); ++k)
            EXPECT_NEAR(made.values[k], picture.values[k], 1e-6);
        // A slope of the same height is none.
        for (std::uint32_t k = 0; k < depth.values.size(); ++k) depth.values[k] = 0.04F * (k % 32);
        const auto across = blurredWithin(picture, depth, 1.0, 4.0);
        EXPECT_GT(across.at(step - 1, 12), 0.4F);
    }
}

TEST(Complexity, ABlurIsAsWideAsItIsSaid) {
    for (const double deviation : {3.0, 6.0, 10.0}) {
        Raster<float> drop(121, 121), depth(121, 121, 1.0F);
        drop.at(60, 60) = 1.0F;
        const auto made = blurredWithin(drop, depth, 1.0, deviation);
        double sum = 0.0, squares = 0.0;
        for (std::uint32_t k = 0; k < made.values.size(); ++k) {
            sum += double(made.values[k]);
            squares += double(made.values[k]) * std::pow(k % 121 - 60.0, 2);
        }
        EXPECT_NEAR(sum, 1.0, 0.02) << deviation;
        EXPECT_NEAR(std::sqrt(squares / sum), deviation, 0.1 * deviation);
    }
}

TEST(Complexity, CoverIsLengthTimesWidth) {
    InkLine line;
    line.points = {{{-10.0, 5.25}}, {{4.0, 5.25}}, {{4.0, 5.75}}};
    const auto cover = coverOf({line}, 8, 8, 2.0);
    EXPECT_NEAR(std::accumulate(cover.values.begin(), cover.values.end(), 0.0), 2.0 * 4.5, 1e-5);
    EXPECT_NEAR(cover.at(2, 5), 2.0, 1e-6);
}

// Particles as a smooth field: what is counted is kept, noise is not, and gaps stay empty.

/// Densities are weights over shares of the box: their mean is the weight of all.
double weightOf(const DensitySamples& samples) {
    const double sum = std::accumulate(samples.values.begin(), samples.values.end(), 0.0);
    return sum / static_cast<double>(samples.values.size());
}

TEST(DensityGrid, KeepsTheWeightOfABeam) {
    const auto points = test::beam({.core = 40000, .halo = 4000, .filaments = 2000, .evenWeights = false});
    double weight = 0.0;
    for (const auto& point : points) weight += point.weight;
    const auto step = test::MemoryStep::make(points, {.volumeLevel = 5});
    const auto counted = densitySamples(*step);
    EXPECT_NEAR(weightOf(counted), weight, 1e-5 * weight);
    const auto made = smoothed(counted, static_cast<double>(points.size()));
    EXPECT_EQ(made.size, 32U);
    EXPECT_NEAR(weightOf(made), weight, 1e-4 * weight);
}

TEST(DensityGrid, TakesMeansOfMoreCells) {
    std::vector<float> volume(std::size_t{256} * 256 * 256);
    for (std::size_t i = 0; i < volume.size(); ++i) volume[i] = static_cast<float>(i % 7 + i / 65536 % 3);
    const auto step = test::MemoryStep::make(test::evenCloud(10, 1), {.volumeLevel = 8, .volume = volume});
    const auto counted = densitySamples(*step);
    EXPECT_EQ(counted.size, mostDensities);
    const double mean =
        std::accumulate(volume.begin(), volume.end(), 0.0) / static_cast<double>(volume.size());
    EXPECT_NEAR(weightOf(counted), mean, 1e-4 * mean);
}

/// A tenth of a particle a cell: what was counted is nearly everywhere nothing.
TEST(DensityGrid, IsEvenWhereParticlesAre) {
    constexpr double particles = 3277.0;
    const auto step = test::MemoryStep::make(test::evenCloud(3277, 2), {.volumeLevel = 5});
    const auto counted = densitySamples(*step), made = smoothed(counted, particles);
    const auto spread = [&](const DensitySamples& samples) {
        double squares = 0.0;
        for (const float value : samples.values)
            squares += (static_cast<double>(value) - particles) * (static_cast<double>(value) - particles);
        return std::sqrt(squares / static_cast<double>(samples.values.size())) / particles;
    };
    EXPECT_GT(spread(counted), 2.5);
    // Some 8 to 64 particles in a kernel: a third, to an eighth.
    EXPECT_LT(spread(made), 0.3);
}

TEST(DensityGrid, LeavesGapsEmpty) {
    auto points = test::evenCloud(60000, 3);
    for (auto& point : points) point.position.x *= 0.5;
    const auto step = test::MemoryStep::make(points, {.volumeLevel = 5});
    const auto made = smoothed(densitySamples(*step), 60000.0);
    const auto at = [&](std::uint32_t x) { return made.values[(std::size_t{16} * 32 + 16) * 32 + x]; };
    EXPECT_NEAR(static_cast<double>(at(8)), 120000.0, 60000.0);
    EXPECT_LT(at(20), 3000.0F);
    EXPECT_LT(at(28), 10.0F);
}

TEST(DensityGrid, IsScaledAsThePlotIs) {
    const auto step =
        test::MemoryStep::make(test::beam({.core = 20000, .halo = 2000, .filaments = 0}), {.volumeLevel = 4});
    const auto field = densityGrid(*step);
    EXPECT_EQ(field->coarse.size, glm::uvec3(16));
    EXPECT_GE(field->coarse.values.size(), 4096U + 4U);
    EXPECT_EQ(field->bounds(), plotBounds);
    const auto made = smoothed(densitySamples(*step), 22000.0);
    for (std::size_t i = 0; i < made.values.size(); ++i) {
        const double t = step->logDensity().ofCell(static_cast<double>(made.values[i]));
        EXPECT_NEAR(field->valueOf(field->coarse.values[i]), t, 1e-5);
    }
    EXPECT_EQ(field->coarse.values[0], 0) << "no particles in the corner";
}

TEST(DensityGrid, SurvivesWhatIsNotThere) {
    const auto none = densityGrid(*test::MemoryStep::make({}));
    EXPECT_EQ(*std::max_element(none->coarse.values.begin(), none->coarse.values.end()), 0);
    const auto one = densityGrid(*test::MemoryStep::make({{glm::dvec3(0.5)}}, {.volumeLevel = 0}));
    EXPECT_EQ(one->coarse.size, glm::uvec3(1));
}

TEST(Raster, PlacesOutsideAreThoseAtItsSide) {
    Raster<int> raster(3, 2);
    raster.at(0, 0) = 1;
    raster.at(2, 1) = 2;
    EXPECT_EQ(raster.near(-1e9, -1.0), 1);
    EXPECT_EQ(raster.near(1e300, 7.0), 2);
    EXPECT_EQ(raster.near(2.5, 1.5), 2);
    EXPECT_EQ(raster.near(std::numeric_limits<double>::quiet_NaN(), 0.0), 1);
}

}  // namespace
}  // namespace mote::render
