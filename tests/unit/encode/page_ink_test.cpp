// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a sheet shows of strokes against what a raster shows of them: its paths, drawn as strokes once more.
#include "server/encode/vector/page_ink.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "server/render/plan/stroke_fragments.h"

namespace mote::server {
namespace {

using render::Stroke;
using render::Strokes;

constexpr std::uint32_t width = 160, height = 120;

/// Ways of pens whose width changes, partly outside the picture, and stars.
Strokes generated(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    Strokes strokes;
    const auto way = [&](int points, float step) {
        const auto begin = static_cast<std::uint32_t>(strokes.points.size());
        float x = (1.4F * unit(random) - 0.2F) * width, y = (1.4F * unit(random) - 0.2F) * height;
        for (int i = 0; i < points; ++i) {
            strokes.points.push_back({x, y, 0.2F + 3.0F * unit(random) * unit(random)});
            x += step * (unit(random) - 0.5F);
            y += step * (unit(random) - 0.5F);
        }
        return Stroke{begin, static_cast<std::uint32_t>(strokes.points.size())};
    };
    for (int i = 0; i < 60; ++i) strokes.lines.push_back(way(1 + i % 9, 24.0F));
    for (std::uint32_t i = 0; i < 6; ++i) {
        strokes.outlines.push_back(way(5, 60.0F));
        strokes.areas.push_back({i, i + 1});
    }
    return strokes;
}

Strokes strokesOf(const PageInk& ink) {
    Strokes strokes;
    const auto add = [&](std::span<const glm::dvec2> path, double wide) {
        const auto begin = static_cast<std::uint32_t>(strokes.points.size());
        for (const auto& at : path)
            strokes.points.push_back(
                {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(wide)});
        return Stroke{begin, static_cast<std::uint32_t>(strokes.points.size())};
    };
    for (const auto& [wide, paths] : ink.lines) {
        for (std::size_t i = 0; i < paths.size(); ++i) strokes.lines.push_back(add(paths.of(i), wide));
    }
    for (std::uint32_t i = 0; i < ink.outlines.size(); ++i) {
        const auto index = static_cast<std::uint32_t>(strokes.outlines.size());
        strokes.outlines.push_back(add(ink.outlines.of(i), 1.0));
        strokes.areas.push_back({index, index + 1});
    }
    for (const auto& area : ink.areas) {
        const auto begin = static_cast<std::uint32_t>(strokes.outlines.size());
        for (std::size_t i = 0; i < area.size(); ++i) strokes.outlines.push_back(add(area.of(i), 1.0));
        strokes.areas.push_back({begin, static_cast<std::uint32_t>(strokes.outlines.size())});
    }
    return strokes;
}

/// How light white paper remains in each pixel.
std::vector<double> paperUnder(Strokes strokes) {
    strokes.areaDepths = {width, height, std::vector<float>(std::size_t{width} * height)};
    std::vector<double> light(std::size_t{width} * height, 1.0);
    for (const auto& part : render::strokeFragments(strokes, width, height, -1.0)) {
        for (const auto& one : part) light[std::size_t{one.row} * width + one.column] *= 1.0 - one.opacity;
    }
    return light;
}

TEST(PageInk, LooksLikeTheRaster) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const auto strokes = generated(seed);
        const auto raster = paperUnder(strokes);
        const auto sheet = paperUnder(strokesOf(inkOnPage(strokes, width, height, false)));
        double squares = 0.0, ink = 0.0, difference = 0.0;
        for (std::size_t i = 0; i < raster.size(); ++i) {
            squares += (raster[i] - sheet[i]) * (raster[i] - sheet[i]);
            ink += 1.0 - raster[i];
            difference += raster[i] - sheet[i];
        }
        // Widths are rounded by up to 2.2% and, changed by up to 10% along a line, are its mean.
        EXPECT_LT(std::abs(difference), 0.02 * ink) << seed;
        EXPECT_LT(std::sqrt(squares / static_cast<double>(raster.size())), 0.03) << seed;
    }
}

/// Else two that cross would be hollow where they do.
TEST(PageInk, OutlinesGoRoundInOneDirection) {
    Strokes strokes;
    strokes.points = {{10.0F, 10.0F, 1.0F}, {50.0F, 20.0F, 4.0F}, {90.0F, 15.0F, 2.0F},
                      {90.0F, 30.0F, 1.0F}, {50.0F, 10.0F, 5.0F}, {20.0F, 25.0F, 1.0F}};
    strokes.lines = {{0, 3}, {3, 6}};
    const auto ink = inkOnPage(strokes, width, height, false);
    ASSERT_EQ(ink.outlines.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        const auto path = ink.outlines.of(i);
        double area = 0.0;
        for (std::size_t j = 0; j < path.size(); ++j) {
            const auto &a = path[j], &b = path[(j + 1) % path.size()];
            area += 0.5 * (a.x * b.y - a.y * b.x);
        }
        EXPECT_GT(area, 50.0);
    }
}

TEST(PageInk, ExtremesDoNoHarm) {
    Strokes strokes;
    strokes.points = {{-1e6F, 5.0F, 0.0F}, {1e6F, 5.0F, 1e6F}, {5.0F, 5.0F, 1e-30F}, {6.0F, 6.0F, 64.0F}};
    strokes.lines = {{0, 2}, {0, 1}, {2, 3}, {2, 4}, {0, 4}};
    strokes.outlines = {{0, 4}, {1, 1}, {2, 3}};
    strokes.areas = {{0, 3}, {1, 2}};
    for (const bool plotter : {false, true}) {
        const auto ink = inkOnPage(strokes, width, height, plotter);
        for (const auto& [wide, paths] : ink.lines) {
            EXPECT_GT(wide, 0.0);
            for (std::size_t i = 0; i < paths.size(); ++i) EXPECT_GE(paths.of(i).size(), 2U);
        }
    }
    EXPECT_TRUE(inkOnPage({}, width, height, true).lines.empty());
}

}  // namespace
}  // namespace mote::server
