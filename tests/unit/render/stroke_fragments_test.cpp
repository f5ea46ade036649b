// SPDX-License-Identifier: GPL-3.0-or-later
//
// Strokes become fragments: the closed forms of what they cover, what is left out, extremes, and that threads
// change nothing.
#include "server/render/plan/stroke_fragments.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "tests/support/random.h"

namespace mote::render {
namespace {

constexpr double everywhere = -std::numeric_limits<double>::infinity();

void addLine(Strokes& strokes, const std::vector<StrokePoint>& points) {
    const auto begin = static_cast<std::uint32_t>(strokes.points.size());
    strokes.points.insert(strokes.points.end(), points.begin(), points.end());
    strokes.lines.push_back({begin, static_cast<std::uint32_t>(strokes.points.size())});
}

/// All areas lie at the depth of the last one.
void addArea(Strokes& strokes, const std::vector<std::vector<StrokePoint>>& outlines, float depth) {
    const auto begin = static_cast<std::uint32_t>(strokes.outlines.size());
    for (const auto& outline : outlines) {
        addLine(strokes, outline);
        strokes.outlines.push_back(strokes.lines.back());
        strokes.lines.pop_back();
    }
    strokes.areas.push_back({begin, static_cast<std::uint32_t>(strokes.outlines.size())});
    strokes.areaDepths = {64, 48, std::vector<float>(64 * 48, depth)};
}

Fragments all(const Strokes& strokes, std::uint32_t width = 64, std::uint32_t height = 48,
              double nearDepth = everywhere) {
    Fragments joined;
    for (const auto& part : strokeFragments(strokes, width, height, nearDepth))
        joined.insert(joined.end(), part.begin(), part.end());
    return joined;
}

double ink(const Fragments& fragments) {
    double sum = 0.0;
    for (const auto& one : fragments) sum += one.opacity;
    return sum;
}

/// That of one pixel, 0 where there is none.
float opacityAt(const Fragments& fragments, std::uint32_t column, std::uint32_t row) {
    for (const auto& one : fragments) {
        if (one.column == column && one.row == row) return one.opacity;
    }
    return 0.0F;
}

std::vector<StrokePoint> rectangle(float left, float top, float right, float bottom) {
    return {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
}

TEST(StrokeFragments, ALineHasAsMuchInkAsItIsWide) {
    for (const float width : {0.05F, 0.3F, 1.0F, 1.7F, 2.5F, 9.0F}) {
        for (const float y : {20.0F, 20.31F, 20.5F, 20.99F}) {
            Strokes strokes;
            addLine(strokes, {{-100.0F, y, width}, {200.0F, y, width}});
            EXPECT_NEAR(ink(all(strokes)), 64.0 * width, 64.0 * 1e-5 * width) << width << " at " << y;
        }
    }
}

TEST(StrokeFragments, AWideLineIsSolidInsideAndRoundAtItsEnds) {
    Strokes strokes;
    addLine(strokes, {{20.0F, 20.0F, 8.0F}, {40.0F, 20.0F, 8.0F}});
    const auto made = all(strokes);
    for (std::uint32_t row = 17; row < 23; ++row) EXPECT_EQ(opacityAt(made, 30, row), 1.0F) << row;
    EXPECT_EQ(opacityAt(made, 30, 24), 0.0F);
    EXPECT_EQ(opacityAt(made, 16, 16), 0.0F);  // the corner of a butt or square end
    EXPECT_NEAR(ink(made), 20.0 * 8.0 + std::numbers::pi * 16.0, 1.0);
}

TEST(StrokeFragments, OneStrokeCoversAPixelOnce) {
    Strokes strokes;
    addLine(strokes, {{10.0F, 20.5F, 0.5F}, {30.0F, 20.5F, 0.5F}, {10.0F, 20.5F, 0.5F}});
    const auto made = all(strokes);
    EXPECT_EQ(opacityAt(made, 20, 20), 0.5F);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> times;
    for (const auto& one : made) EXPECT_EQ(++times[std::pair(one.column, one.row)], 1);
}

TEST(StrokeFragments, WidthAndDepthGoAlongALine) {
    Strokes strokes;
    addLine(strokes, {{10.5F, 20.5F, 0.2F, 1.0}, {30.5F, 20.5F, 0.6F, 5.0}});
    for (const auto& one : all(strokes)) {
        if (one.row != 20 || one.column < 10 || one.column > 30) continue;
        const double share = (one.column - 10) / 20.0;
        EXPECT_NEAR(one.opacity, 0.2 + 0.4 * share, 1e-6);
        EXPECT_NEAR(one.depth, 1.0 + 4.0 * share, 1e-12);
    }
}

TEST(StrokeFragments, AnAreaIsAsLargeAsItsOutlinesSay) {
    Strokes disc;
    std::vector<StrokePoint> around;
    for (int i = 0; i < 500; ++i) {
        const double angle = i * std::numbers::pi / 250.0;
        around.push_back({static_cast<float>(30.3 + 12.0 * std::cos(angle)),
                          static_cast<float>(20.7 + 12.0 * std::sin(angle))});
    }
    addArea(disc, {around}, 3.0F);
    EXPECT_NEAR(ink(all(disc)), std::numbers::pi * 144.0, 0.3);
    for (const auto& one : all(disc)) EXPECT_EQ(one.depth, 3.0);

    Strokes frame;
    addArea(frame, {rectangle(10.25F, 10.25F, 30.75F, 30.5F), rectangle(15.5F, 15.5F, 20.0F, 20.0F)}, 3.0F);
    EXPECT_NEAR(ink(all(frame)), 20.5 * 20.25 - 4.5 * 4.5, 1e-3);
    EXPECT_EQ(opacityAt(all(frame), 17, 17), 0.0F);
    EXPECT_EQ(opacityAt(all(frame), 12, 12), 1.0F);
    EXPECT_NEAR(opacityAt(all(frame), 10, 10), 0.75 * 0.75, 1e-6);
}

TEST(StrokeFragments, AnAreaLiesAtTheDepthOfEachPixel) {
    Strokes strokes;
    addArea(strokes, {rectangle(10.0F, 10.0F, 20.0F, 30.0F)}, 1.0F);
    auto& depths = strokes.areaDepths;
    for (std::uint32_t i = 0; i < 64 * 48; ++i) depths.values[i] = static_cast<float>(i % 64);
    depths.values[12 * 64 + 13] = AreaDepths::none;
    depths.values[12 * 64 + 14] = std::nanf("");
    const auto made = all(strokes);
    EXPECT_EQ(made.size(), 10U * 20U - 2U);
    for (const auto& one : made) EXPECT_EQ(one.depth, one.column);
    EXPECT_EQ(opacityAt(made, 13, 12), 0.0F);
    EXPECT_EQ(opacityAt(made, 15, 12), 1.0F);
    // A picture that is larger than its depths.
    depths = {12, 48, std::vector<float>(12 * 48, 1.0F)};
    EXPECT_EQ(all(strokes).size(), 2U * 20U);
}

TEST(StrokeFragments, WhatCrossesItselfIsOutsideWhereItGoesAroundTwice) {
    Strokes twice;
    auto outline = rectangle(10.0F, 10.0F, 20.0F, 20.0F);
    const auto inner = rectangle(12.0F, 12.0F, 16.0F, 16.0F);
    outline.push_back(outline.front());
    outline.insert(outline.end(), inner.begin(), inner.end());
    outline.push_back(inner.front());
    addArea(twice, {outline}, 1.0F);
    EXPECT_NEAR(ink(all(twice)), 100.0 - 16.0, 1e-3);
}

TEST(StrokeFragments, NothingIsNearerThanWhatIsSeen) {
    Strokes strokes;
    addLine(strokes, {{10.0F, 20.5F, 1.0F, 0.0}, {30.0F, 20.5F, 1.0F, 2.0}});
    addArea(strokes, {rectangle(1.0F, 1.0F, 5.0F, 5.0F)}, 0.5F);
    const auto made = all(strokes, 64, 48, 1.0);
    EXPECT_FALSE(made.empty());
    for (const auto& one : made) EXPECT_GE(one.depth, 1.0);
}

TEST(StrokeFragments, PointsFarAwayAndWideLinesDoNoHarm) {
    Strokes strokes;
    addLine(strokes, {{-1e6F, -1e6F, 1.0F}, {1e6F, 1e6F, 1.0F}});
    addLine(strokes, {{-1e6F, 30.0F, 64.0F}, {1e6F, 30.0F, 64.0F}});
    addLine(strokes, {{1e6F, 1e6F, 64.0F}, {1e6F, 1e6F, 64.0F}});
    addLine(strokes, {{5.0F, 5.0F, 0.0F}, {6.0F, 6.0F, 0.0F}});
    addLine(strokes, {{32.0F, 24.0F, 1e9F}});
    addArea(strokes, {rectangle(-1e6F, -1e6F, 1e6F, 1e6F)}, 2.0F);
    addArea(strokes, {{{3.0F, 3.0F}}, {{4.0F, 4.0F}, {9.0F, 4.0F}}, {}}, 2.0F);
    const auto made = all(strokes);
    for (const auto& one : made) {
        EXPECT_LT(one.column, 64U);
        EXPECT_LT(one.row, 48U);
        EXPECT_GT(one.opacity, 0.0F);
        EXPECT_LE(one.opacity, 1.0F);
    }
    const auto onDiagonal = [](const Fragment& one) { return one.column == 20 && one.row == 20; };
    EXPECT_EQ(std::count_if(made.begin(), made.end(), onDiagonal), 4);
}

TEST(StrokeFragments, ThreadsChangeNothing) {
    test::Random random(7);
    Strokes strokes;
    for (int i = 0; i < 400; ++i) {
        std::vector<StrokePoint> points;
        for (int j = 0; j < 1 + i % 5; ++j)
            points.push_back({static_cast<float>(random.between(-20.0, 84.0)),
                              static_cast<float>(random.between(-20.0, 68.0)),
                              static_cast<float>(random.between(0.0, 6.0)), random.between(0.0, 4.0)});
        i % 7 == 0 ? addArea(strokes, {points}, 2.0F) : addLine(strokes, points);
    }
    tbb::task_arena one(1), two(2);
    const auto alone = one.execute([&] { return all(strokes); });
    const auto shared = two.execute([&] { return all(strokes); });
    ASSERT_EQ(alone.size(), shared.size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
        EXPECT_EQ(std::tie(alone[i].column, alone[i].row, alone[i].depth, alone[i].opacity),
                  std::tie(shared[i].column, shared[i].row, shared[i].depth, shared[i].opacity));
    }
}

/// What all fragments of each pixel that lie before a depth hide together.
std::map<std::pair<std::uint32_t, std::uint32_t>, double> hidden(const Fragments& fragments, double before) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> left;
    for (const auto& one : fragments) {
        if (one.depth < before)
            left.try_emplace({one.column, one.row}, 1.0).first->second *= 1.0 - one.opacity;
    }
    for (auto& [pixel, share] : left) share = 1.0 - share;
    return left;
}

TEST(StrokeFragments, InkThatFadesIsAsPaleInEachPixelAndBeforeEachDepth) {
    test::Random random(3);
    Strokes strokes;
    for (int i = 0; i < 60; ++i) {
        std::vector<StrokePoint> points;
        for (int j = 0; j < 1 + i % 4; ++j)
            points.push_back({static_cast<float>(random.between(0.0, 64.0)),
                              static_cast<float>(random.between(0.0, 48.0)),
                              static_cast<float>(random.between(0.2, 6.0)), random.between(0.0, 4.0)});
        addLine(strokes, points);
    }
    addArea(strokes, {rectangle(10.25F, 10.25F, 30.75F, 30.5F)}, 2.0F);
    const auto whole = all(strokes);
    for (const float opacity : {0.999F, 0.3F, 0.01F}) {
        strokes.opacity = opacity;
        const auto pale = all(strokes);
        for (const double before : {1.0, 2.0, 3.0, 9.0}) {
            const auto much = hidden(whole, before), little = hidden(pale, before);
            ASSERT_EQ(much.size(), little.size());
            for (const auto& [pixel, share] : much) EXPECT_NEAR(little.at(pixel), opacity * share, 1e-6);
        }
    }
    strokes.opacity = 0.0F;
    EXPECT_TRUE(all(strokes).empty());
}

TEST(StrokeFragments, NothingMakesNothing) {
    EXPECT_TRUE(all({}).empty());
    Strokes outside;
    addLine(outside, {{100.0F, 20.0F, 3.0F}, {90.0F, 30.0F, 3.0F}});
    EXPECT_TRUE(all(outside).empty());
}

}  // namespace
}  // namespace mote::render
