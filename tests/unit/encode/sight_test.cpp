// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies before the shapes of a page: how it is found by pictures of probes, and how shapes are cut by it.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/packing.hpp>
#include <numbers>

#include "protocol/scene/srgb.h"
#include "server/encode/vector/cut_shapes.h"
#include "server/encode/vector/sight_probe.h"
#include "tests/support/random.h"

namespace mote::server {
namespace {

using render::PixelFormat, render::Strokes, render::StrokePoint;
using test::Random;

constexpr std::uint32_t side = 12;  // pixels of a picture

double areaOf(const std::vector<glm::dvec2>& path) {
    double twice = 0.0;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const auto &a = path[i], &b = path[(i + 1) % path.size()];
        twice += a.x * b.y - a.y * b.x;
    }
    return 0.5 * std::abs(twice);
}

/// Panes in a pixel, each with its depth, the share that it hides and its grey.
struct Pane {
    double depth;
    float opacity, grey;
};

InFront before(const std::vector<Pane>& panes, double depth) {
    InFront seen;
    for (const auto& pane : panes) {  // ascending
        if (pane.depth >= depth) break;
        seen.light += glm::vec3(seen.through * pane.opacity * pane.grey);
        seen.through *= 1.0F - pane.opacity;
    }
    return seen;
}

/// All pixels' panes, and pictures of probes among them.
class World {
  public:
    explicit World(Random& random) : panes_(side * side) {
        for (auto& panes : panes_) {
            double depth = 0.0;
            for (auto count = random.below(4); count > 0; --count) {
                depth += random.between(0.1, 1.0);
                panes.push_back(
                    {depth, random.oneOf({1.0F, 0.5F, 0.25F}), static_cast<float>(random.unit())});
            }
        }
    }
    InFront at(const SightPlace& place) const { return before(panes_[place.pixel], place.depth); }
    render::Picture picture(const std::vector<SightPlace>& probes, float grey) const {
        render::Picture made{side, side, PixelFormat::linearHalf, {}, 0};
        std::vector<std::uint16_t> halves(std::size_t{4} * side * side, glm::packHalf1x16(0.37F));
        for (const auto& place : probes) {
            const auto seen = at(place).seen(glm::vec3(grey));
            for (int c = 0; c < 3; ++c) halves[std::size_t{4} * place.pixel + c] = glm::packHalf1x16(seen[c]);
        }
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(halves.data());
        made.pixels.assign(bytes, bytes + 2 * halves.size());
        return made;
    }

  private:
    std::vector<std::vector<Pane>> panes_;
};

TEST(SightProbe, FindsWhatLiesBeforeEveryPlace) {
    Random random(1, 2);
    for (int round = 0; round < 20; ++round) {
        const World world(random);
        std::vector<SightPlace> places;
        for (int i = 0; i < 600; ++i)
            places.push_back(
                {static_cast<std::uint32_t>(random.below(side * side)), random.between(-0.5, 3.0)});
        SightProbe probe(side, places);
        int pictures = 0;
        while (!probe.wanted().empty()) {
            ASSERT_LT(++pictures, 9);
            for (std::size_t i = 1; i < probe.wanted().size(); ++i)
                ASSERT_LT(probe.wanted()[i - 1].pixel, probe.wanted()[i].pixel) << "one place a pixel";
            probe.learn(world.picture(probe.wanted(), 0.0F), world.picture(probe.wanted(), 1.0F));
        }
        const auto sight = probe.take();
        for (const auto& place : places) {
            const auto seen = sight.at(place.pixel % side, place.pixel / side, place.depth);
            const auto right = world.at(place);
            ASSERT_NEAR(seen.through, right.through, 0.005);
            if (right.hidden()) continue;
            ASSERT_NEAR(seen.light.x, right.light.x, 0.005);
        }
    }
}

TEST(SightProbe, OfWhatNothingHidesAsksOnce) {
    SightProbe probe(side, {{3, 1.0}, {3, 2.0}, {3, -std::numeric_limits<double>::infinity()}, {5, 1.0}});
    ASSERT_EQ(probe.wanted().size(), 2U);
    EXPECT_EQ(probe.wanted()[0], (SightPlace{3, 2.0}));
    const render::Picture black{side, side, PixelFormat::linearHalf,
                                std::vector<std::uint8_t>(std::size_t{8} * side * side), 0};
    auto white = black;
    const std::uint16_t one = glm::packHalf1x16(1.0F);
    for (std::size_t i = 0; i < white.pixels.size(); i += 2) std::memcpy(&white.pixels[i], &one, 2);
    probe.learn(black, white);
    EXPECT_TRUE(probe.wanted().empty());
    EXPECT_TRUE(probe.take().at(3, 0, 1.0).clear());
}

TEST(ClippedPaths, HaveTheAreaOfWhatTheyShare) {
    const auto disc = discPath(3.0);
    EXPECT_NEAR(areaOf(disc), 9.0 * std::numbers::pi, 1e-9);
    EXPECT_NEAR(areaOf(clipped(disc, {{-4.0, -4.0}, {0.0, 4.0}})), 4.5 * std::numbers::pi, 1e-9);
    EXPECT_NEAR(areaOf(clipped(disc, {{-1.0, -1.0}, {1.0, 0.5}})), 3.0, 1e-12);
    EXPECT_TRUE(clipped(disc, {{4.0, 4.0}, {5.0, 5.0}}).empty());
    // A path that falls apart in two.
    const std::vector<glm::dvec2> fork{{0, 0}, {4, 0}, {4, 4}, {3, 4}, {3, 1}, {1, 1}, {1, 4}, {0, 4}};
    EXPECT_NEAR(areaOf(clipped(fork, {{0.0, 2.0}, {4.0, 3.0}})), 2.0, 1e-12);
}

/// All of the picture left of a column lies behind something that lets so much through and sends so much.
Sight behind(std::uint32_t columns, double depth, const InFront& inFront) {
    std::vector<SightPlace> places;
    for (std::uint32_t row = 0; row < side; ++row) {
        for (std::uint32_t column = 0; column < columns; ++column)
            places.push_back({row * side + column, depth});
    }
    return {side, places, std::vector<InFront>(places.size(), inFront)};
}

constexpr InFront wall{glm::vec3(0.25F), 0.0F}, veil{glm::vec3(0.25F), 0.5F};
constexpr PictureSize size{side, side};

TEST(SeenDots, AreCutWherePixelsAreHidden) {
    const render::Dot dot{6.0F, 6.0F, 2.0, 3.0F, 1.0F, glm::vec3(1.0F, 0.0F, 0.0F)};
    const auto whole = seenOf(dot, Sight(side, {}, {}), size, false);
    ASSERT_EQ(whole.size(), 1U);
    EXPECT_TRUE(whole[0].outline.empty());
    EXPECT_EQ(whole[0].color, dot.color);
    EXPECT_TRUE(seenOf(dot, behind(side, 2.0, wall), size, false).empty());

    double area = 0.0;
    for (const auto& piece : seenOf(dot, behind(6, 2.0, wall), size, false)) {
        EXPECT_EQ(piece.color, dot.color);
        area += areaOf(piece.outline);
        for (const auto& corner : piece.outline) EXPECT_GE(corner.x, 0.0);
    }
    // Without corners of pixels that the dot is not told to cover.
    EXPECT_NEAR(area, 4.5 * std::numbers::pi, 0.1);

    const auto paled = seenOf(dot, behind(side, 2.0, veil), size, false);
    ASSERT_EQ(paled.size(), 1U);
    EXPECT_TRUE(paled[0].outline.empty());
    EXPECT_NEAR(paled[0].color.x, 0.75F, 1e-6);
    EXPECT_NEAR(paled[0].color.y, 0.25F, 1e-6);
    EXPECT_TRUE(seenOf(dot, behind(7, 2.0, wall), size, true).empty()) << "a pen draws a dot or none";
    EXPECT_EQ(seenOf(dot, behind(5, 2.0, wall), size, true).size(), 1U);
}

/// A line from the left to the right, and a square area.
Strokes lineAndArea(bool area) {
    Strokes strokes;
    strokes.color = glm::vec3(1.0F, 0.0F, 0.0F);
    strokes.points = {{1.0F, 6.5F, 2.0F, 2.0}, {4.0F, 6.5F, 2.0F, 2.0}, {11.0F, 6.5F, 2.0F, 2.0}};
    if (!area) {
        strokes.lines = {{0, 3}};
        return strokes;
    }
    strokes.points = {{2.0F, 2.0F, 1.0F, 0.0},
                      {10.0F, 2.0F, 1.0F, 0.0},
                      {10.0F, 10.0F, 1.0F, 0.0},
                      {2.0F, 10.0F, 1.0F, 0.0}};
    strokes.outlines = {{0, 4}};
    strokes.areas = {{0, 1}};
    strokes.areaDepths = {side, side, std::vector<float>(side * side, 2.0F)};
    return strokes;
}

double lengthOf(const Strokes& strokes) {
    double length = 0.0;
    for (const auto& line : strokes.lines) {
        for (auto i = line.begin + 1; i < line.end; ++i)
            length += std::abs(strokes.points[i].x - strokes.points[i - 1].x);
    }
    return length;
}

double inkOf(const Strokes& strokes) {
    double sum = 0.0;
    for (const auto& outline : strokes.outlines) {
        std::vector<glm::dvec2> path;
        for (auto i = outline.begin; i < outline.end; ++i)
            path.emplace_back(strokes.points[i].x, strokes.points[i].y);
        sum += areaOf(path);
    }
    return sum;
}

TEST(SeenStrokes, LinesAreCutWhereTheyAreHidden) {
    const auto line = lineAndArea(false);
    const auto whole = seenOf(line, Sight(side, {}, {}), size, false);
    ASSERT_EQ(whole.size(), 1U);
    EXPECT_EQ(whole[0].points, line.points);
    EXPECT_TRUE(seenOf(line, behind(side, 2.0, wall), size, false)[0].lines.empty());
    const auto half = seenOf(line, behind(7, 2.0, wall), size, false);
    ASSERT_EQ(half.size(), 1U);
    // Its round end covers as much as a straight one at the cut would.
    EXPECT_NEAR(lengthOf(half[0]), 4.0 - 0.25 * std::numbers::pi, 1e-5);

    const auto veiled = seenOf(line, behind(7, 2.0, veil), size, false);
    ASSERT_EQ(veiled.size(), 2U);
    EXPECT_EQ(veiled[0].color, line.color);
    EXPECT_NEAR(veiled[1].color.x, 0.75F, 0.02F);
    EXPECT_NEAR(veiled[1].color.y, 0.25F, 0.02F);
    EXPECT_NEAR(lengthOf(veiled[0]) + lengthOf(veiled[1]), 10.0, 2.0);
    const auto plotted = seenOf(line, behind(7, 2.0, veil), size, true);
    ASSERT_EQ(plotted.size(), 1U);
    EXPECT_NEAR(lengthOf(plotted[0]), 10.0, 1e-5);
}

TEST(SeenStrokes, AreasAreCutWhereTheyAreHidden) {
    const auto area = lineAndArea(true);
    EXPECT_NEAR(inkOf(seenOf(area, Sight(side, {}, {}), size, false)[0]), 64.0, 1e-9);
    EXPECT_TRUE(seenOf(area, behind(side, 2.0, wall), size, false)[0].areas.empty());
    EXPECT_NEAR(inkOf(seenOf(area, behind(7, 2.0, wall), size, false)[0]), 24.0, 1e-6);
    const auto veiled = seenOf(area, behind(7, 2.0, veil), size, false);
    ASSERT_EQ(veiled.size(), 2U);
    EXPECT_NEAR(inkOf(veiled[0]), 24.0, 1e-6);
    EXPECT_NEAR(inkOf(veiled[1]), 40.0, 1e-6);
}

TEST(Paint, GivesThePicturesColour) {
    Random random(3, 4);
    for (int i = 0; i < 2000; ++i) {
        const auto any = [&] { return glm::vec3(random.unit(), random.unit(), random.unit()); };
        const auto color = any(), beneath = any();
        const double opacity = random.between(0.01, 1.0);
        const auto paint = paintOver(color, opacity, beneath);
        EXPECT_GE(paint.opacity, opacity - 1e-9);
        const auto share = static_cast<float>(paint.opacity), mixed = static_cast<float>(opacity);
        const auto shown = share * paint.color + (1.0F - share) * encoded(beneath);
        const auto right = encoded(mixed * color + (1.0F - mixed) * beneath);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], right[c], 1e-4);
    }
}

}  // namespace
}  // namespace mote::server
