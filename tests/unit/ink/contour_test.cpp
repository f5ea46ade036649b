// SPDX-License-Identifier: GPL-3.0-or-later
//
// Outlines of generated pictures: areas of closed forms, what is inside, that nothing crosses.
#include "server/render/ink/contour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "tests/support/random.h"

namespace mote::render {
namespace {

double areaOf(const std::vector<Outline>& outlines) {
    double sum = 0.0;
    for (const auto& outline : outlines) sum += signedArea(outline);
    return sum;
}

template <class Value>
Raster<float> pictureOf(std::uint32_t width, std::uint32_t height, const Value& value) {
    Raster<float> picture(width, height);
    for (std::uint32_t row = 0; row < height; ++row) {
        for (std::uint32_t column = 0; column < width; ++column)
            picture.at(column, row) = static_cast<float>(value(glm::dvec2(column + 0.5, row + 0.5)));
    }
    return picture;
}

/// Waves of all directions, none shorter than `shortest` pixels.
Raster<float> waves(test::Random& random, std::uint32_t side, double shortest) {
    struct Wave {
        glm::dvec2 way;
        double phase;
    };
    std::vector<Wave> all;
    for (int i = 0; i < 12; ++i) {
        const double angle = random.between(0.0, 2.0 * std::numbers::pi);
        const double length = random.between(shortest, 4.0 * shortest);
        all.push_back({2.0 * std::numbers::pi / length * glm::dvec2(std::cos(angle), std::sin(angle)),
                       random.between(0.0, 7.0)});
    }
    return pictureOf(side, side, [&](const glm::dvec2& at) {
        double sum = 0.0;
        for (const auto& wave : all) sum += std::sin(glm::dot(wave.way, at) + wave.phase);
        return sum;
    });
}

template <class Take>
void eachSegment(const std::vector<Outline>& outlines, const Take& take) {
    for (const auto& outline : outlines) {
        const auto& points = outline.points;
        for (std::size_t i = 0; i < points.size(); ++i) take(points[i], points[(i + 1) % points.size()]);
    }
}

double distanceTo(const glm::dvec2& at, const glm::dvec2& from, const glm::dvec2& to) {
    const glm::dvec2 way = to - from;
    const double share = std::clamp(glm::dot(at - from, way) / glm::dot(way, way), 0.0, 1.0);
    return glm::distance(at, from + share * way);
}

TEST(Contour, DiscsHaveTheirArea) {
    test::Random random(3);
    for (int i = 0; i < 40; ++i) {
        const double radius = random.between(6.0, 30.0);
        const glm::dvec2 middle(random.between(32.0, 40.0), random.between(32.0, 40.0));
        const auto disc =
            pictureOf(72, 72, [&](const glm::dvec2& at) { return radius - glm::distance(at, middle); });
        const auto outlines = contoursOf(disc, 0.0F, {});
        ASSERT_EQ(outlines.size(), 1U);
        EXPECT_NEAR(areaOf(outlines) / (std::numbers::pi * radius * radius), 1.0, 0.01) << radius;
        for (const auto& point : outlines[0].points) EXPECT_NEAR(glm::distance(point, middle), radius, 0.05);
        // Rows and columns of pixels meet a circle about 8 r times.
        EXPECT_LT(outlines[0].points.size(), 8.0 * radius);
    }
}

TEST(Contour, BlobsHaveTheirArea) {
    test::Random random(4);
    for (int i = 0; i < 30; ++i) {
        const auto picture = waves(random, 96, 12.0);
        double inside = 0.0, around = 0.0;
        for (const float value : picture.values) inside += value >= 0.5F ? 1.0 : 0.0;
        const auto outlines = contoursOf(picture, 0.5F, {});
        eachSegment(outlines, [&](const auto& from, const auto& to) { around += glm::distance(from, to); });
        // Where an outline cuts a pixel is even, so errors along it grow with the root of its length.
        EXPECT_NEAR(areaOf(outlines), inside, 1.5 * std::sqrt(around) + 0.01 * inside);
    }
}

TEST(Contour, GoesAroundWhatIsInside) {
    test::Random random(5);
    for (int i = 0; i < 12; ++i) {
        const auto picture = waves(random, 48, i % 2 == 0 ? 10.0 : 3.0);
        const auto outlines = contoursOf(picture, 0.0F, {});
        for (std::uint32_t row = 0; row < 48; ++row) {
            for (std::uint32_t column = 0; column < 48; ++column) {
                const glm::dvec2 at(column + 0.5, row + 0.5);
                bool inside = false;
                double nearest = HUGE_VAL;
                eachSegment(outlines, [&](const glm::dvec2& from, const glm::dvec2& to) {
                    nearest = std::min(nearest, distanceTo(at, from, to));
                    if ((from.y <= at.y) == (to.y <= at.y)) return;
                    if (from.x + (at.y - from.y) / (to.y - from.y) * (to.x - from.x) > at.x) inside = !inside;
                });
                // What is smaller has no outline.
                if (nearest > 0.0313 && std::abs(picture.at(column, row)) > 0.1F) {
                    EXPECT_EQ(inside, picture.at(column, row) >= 0.0F) << column << ' ' << row;
                }
            }
        }
    }
}

TEST(Contour, CrossesNothing) {
    test::Random random(6);
    const auto side = [](const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
        return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    };
    for (int i = 0; i < 10; ++i) {
        const auto outlines = contoursOf(waves(random, 64, 8.0), 0.0F, {});
        std::vector<std::pair<glm::dvec2, glm::dvec2>> all;
        eachSegment(outlines, [&](const auto& from, const auto& to) { all.emplace_back(from, to); });
        for (std::size_t a = 0; a < all.size(); ++a) {
            for (std::size_t b = a + 1; b < all.size(); ++b) {
                const auto& [p, q] = all[a];
                const auto& [r, s] = all[b];
                EXPECT_FALSE(side(p, q, r) * side(p, q, s) < 0.0 && side(r, s, p) * side(r, s, q) < 0.0);
            }
        }
    }
}

/// Rings within rings, a gap between any two.
TEST(Contour, TellsHolesFromRegions) {
    const glm::dvec2 middle(40.3, 39.8);
    const auto rings = pictureOf(80, 80, [&](const glm::dvec2& at) {
        const double distance = glm::distance(at, middle);
        return distance > 36.0 ? -1.0 : std::cos(std::numbers::pi / 6.0 * distance);
    });
    const auto outlines = contoursOf(rings, 0.0F, {});
    ASSERT_EQ(outlines.size(), 7U);  // circles of 3, 9, 15, ... pixels
    for (std::size_t i = 0; i < outlines.size(); ++i) {
        EXPECT_EQ(signedArea(outlines[i]) > 0.0, i % 2 == 0) << i;
        EXPECT_EQ(i > 0 && outlines[i].region == outlines[i - 1].region, i % 2 == 1) << i;
    }
}

TEST(Contour, JoinsOppositeCornersByTheirMean) {
    Raster<float> corners(2, 2);
    corners.values = {1.0F, -0.5F, -0.5F, 1.0F};
    EXPECT_EQ(contoursOf(corners, 0.0F, {}).size(), 1U);
    corners.values = {0.5F, -1.0F, -1.0F, 0.5F};
    const auto apart = contoursOf(corners, 0.0F, {});
    ASSERT_EQ(apart.size(), 2U);
    EXPECT_NE(apart[0].region, apart[1].region);
}

TEST(Contour, APicturesSidesAreOutlines) {
    for (const auto& [width, height] : {std::pair(1U, 1U), std::pair(1U, 9U), std::pair(40U, 30U)}) {
        const auto outlines = contoursOf(Raster<float>(width, height, 2.0F), 1.0F, {});
        ASSERT_EQ(outlines.size(), 1U);
        // An eighth of a pixel is cut off each corner.
        EXPECT_NEAR(areaOf(outlines), width * height - 0.5, 0.26);
        for (const auto& at : outlines[0].points)
            EXPECT_TRUE(at.x >= 0.0 && at.y >= 0.0 && at.x <= width && at.y <= height);
    }
    EXPECT_TRUE(contoursOf(Raster<float>(40, 30, 0.5F), 1.0F, {}).empty());
    EXPECT_TRUE(contoursOf({}, 1.0F, {}).empty());
}

TEST(Contour, NumbersThatAreNoneDoNoHarm) {
    test::Random random(7);
    for (int i = 0; i < 20; ++i) {
        auto picture = waves(random, 40, 4.0);
        for (auto& value : picture.values) {
            if (random.chance(0.3))
                value = random.oneOf({std::nanf(""), HUGE_VALF, -HUGE_VALF, 3e38F, -3e38F, 0.0F});
        }
        for (const float level : {0.0F, 3e38F, HUGE_VALF, std::nanf("")}) {
            for (const auto& outline : contoursOf(picture, level, {})) {
                EXPECT_GE(outline.points.size(), 3U);
                for (const auto& at : outline.points)
                    EXPECT_TRUE(at.x >= 0.0 && at.y >= 0.0 && at.x <= 40.0 && at.y <= 40.0);
            }
        }
    }
}

TEST(Contour, ARequestToStopIsHeard) {
    std::stop_source source;
    source.request_stop();
    EXPECT_TRUE(contoursOf(Raster<float>(8, 8, 1.0F), 0.0F, source.get_token()).empty());
}

}  // namespace
}  // namespace mote::render
