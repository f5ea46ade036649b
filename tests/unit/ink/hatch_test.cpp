// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hatches cover what they should, where they should, and nothing elsewhere changes.
#include "server/render/ink/hatch.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <set>

#include "server/render/ink/tone_grid.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_cover.h"

namespace mote::render {
namespace {

constexpr std::uint32_t hatchSide = 160;

struct Region {
    Raster<std::uint32_t> label;
    Raster<float> angle, density;

    Region(std::uint32_t size, float direction, double wanted)
        : label(size, size), angle(size, size, direction), density(size, size, static_cast<float>(wanted)) {}

    std::vector<HatchStroke> hatched(const HatchOptions& options, std::uint32_t count = 1) const {
        const HatchRegions regions{label, count, angle, density};
        return hatch(regions, hatchAxes(regions), options, {});
    }
};

/// The mean density of ink in the middle of a square that is hatched all over.
double drawnDensity(const std::vector<HatchStroke>& strokes, double width, std::uint32_t size) {
    Strokes made;
    for (const auto& stroke : strokes) test::addStroke(made, {stroke.from, stroke.to}, width);
    return densityOf(test::meanOf(test::coverOf(made, size, size), size / 8));
}

double lengthOf(const std::vector<HatchStroke>& strokes) {
    double length = 0.0;
    for (const auto& stroke : strokes) length += glm::distance(stroke.from, stroke.to);
    return length;
}

// Regions of many pixels are hatched in pieces, which leave no trace.
TEST(Hatch, NoStrokeOfALargeRegionIsBroken) {
    constexpr std::uint32_t large = 500;
    for (const double spacing : {3.0, 7.0}) {
        const HatchOptions options{.spacing = spacing, .width = 1.0};
        const Region region(large, 0.4F, mostHatched(options));
        const auto strokes = region.hatched(options);
        std::set<std::array<std::int64_t, 2>> lines;  // by direction and distance, in thousandths
        std::size_t count = 0;
        for (const auto& stroke : strokes) {
            if (glm::distance(stroke.from, stroke.to) < 5.0) continue;  // in a corner: of no clear direction
            const auto way = glm::normalize(stroke.to - stroke.from);
            const double distance = way.x * stroke.from.y - way.y * stroke.from.x;
            lines.insert({std::llround(1e3 * std::atan2(way.y, way.x)), std::llround(1e3 * distance)});
            ++count;
        }
        EXPECT_EQ(lines.size(), count);
        const double length = lengthOf(strokes);
        // Eight layers, of which each has the area over its spacing.
        EXPECT_NEAR(length, 8.0 * large * large / spacing, 0.01 * length);
        EXPECT_NEAR(coverOf(drawnDensity(strokes, options.width, large)), coverOf(mostHatched(options)),
                    0.032);
    }
}

TEST(Hatch, CoversWhatIsWanted) {
    for (const double spacing : {4.0, 12.0}) {
        for (const float direction : {0.3F, 1.2F, -0.7F}) {
            const HatchOptions options{.spacing = spacing, .width = 1.0};
            const double most = mostHatched(options);
            double sum = 0.0, count = 0.0;
            for (int i = 0; i < 24; ++i) {
                const double wanted = std::lerp(0.05, most, i / 23.0);
                const Region region(hatchSide, direction, wanted);
                const double drawn = drawnDensity(region.hatched(options), options.width, hatchSide);
                // Strokes come a quarter of a layer at a time.
                EXPECT_NEAR(coverOf(drawn), coverOf(wanted), 0.032)
                    << spacing << ' ' << direction << ' ' << wanted;
                sum += coverOf(drawn) - coverOf(wanted);
                count += 1.0;
            }
            EXPECT_NEAR(sum / count, 0.0, 0.03) << spacing << ' ' << direction;
        }
    }
}

/// Blobs of labels, each of its own direction and density.
Region blobs(test::Random& random, std::uint32_t count) {
    Region region(hatchSide, 0.0F, 0.0);
    std::vector<glm::dvec2> middles;
    std::vector<float> angles, densities;
    for (std::uint32_t i = 0; i < count; ++i) {
        middles.emplace_back(random.between(0.0, hatchSide), random.between(0.0, hatchSide));
        angles.push_back(static_cast<float>(random.between(-3.0, 3.0)));
        densities.push_back(static_cast<float>(random.between(0.0, 1.5)));
    }
    for (std::uint32_t row = 0; row < hatchSide; ++row) {
        for (std::uint32_t column = 0; column < hatchSide; ++column) {
            std::uint32_t nearest = 0;
            for (std::uint32_t i = 1; i < count; ++i) {
                const glm::dvec2 at(column, row);
                if (glm::distance(at, middles[i]) < glm::distance(at, middles[nearest])) nearest = i;
            }
            region.label.at(column, row) = nearest;
            region.angle.at(column, row) = angles[nearest] + static_cast<float>(random.between(-0.3, 0.3));
            region.density.at(column, row) = densities[nearest];
        }
    }
    return region;
}

TEST(Hatch, StaysInsideItsRegion) {
    test::Random random(1);
    for (int turn = 0; turn < 5; ++turn) {
        auto region = blobs(random, 9);
        // All but one are beyond the count.
        for (auto& label : region.label.values) label = label == 4 ? 0 : label + 1;
        for (auto& density : region.density.values) density = 1.0F;
        const auto strokes = region.hatched({}, 1);
        EXPECT_FALSE(strokes.empty());
        for (const auto& stroke : strokes) {
            for (int i = 0; i <= 50; ++i) {
                const glm::dvec2 at = stroke.from + i / 50.0 * (stroke.to - stroke.from);
                bool inside = false;
                for (const double x : {-1.0, 0.0, 1.0}) {
                    for (const double y : {-1.0, 0.0, 1.0})
                        inside = inside || region.label.near(at.x + x, at.y + y) == 0;
                }
                ASSERT_TRUE(inside) << at.x << ' ' << at.y;
                ASSERT_TRUE(at.x >= -1e-9 && at.y >= -1e-9 && at.x <= hatchSide + 1e-9 &&
                            at.y <= hatchSide + 1e-9);
            }
        }
    }
}

TEST(Hatch, TheFirstLayerGoesTheMeanWay) {
    test::Random random(2);
    for (int turn = 0; turn < 20; ++turn) {
        const double wanted = random.between(-3.1, 3.1);
        Region region(64, 0.0F, 0.1);
        // Directions have no sign.
        for (auto& angle : region.angle.values) {
            const double flipped = random.chance(0.5) ? std::numbers::pi : 0.0;
            angle = static_cast<float>(wanted + flipped + random.between(-0.5, 0.5));
        }
        const auto strokes = region.hatched({});
        ASSERT_FALSE(strokes.empty());
        for (const auto& stroke : strokes) {
            const glm::dvec2 way = glm::normalize(stroke.to - stroke.from);
            EXPECT_LT(std::abs(way.x * std::sin(wanted) - way.y * std::cos(wanted)), 0.03);
        }
    }
}

TEST(Hatch, WhatChangesInOneRegionLeavesTheOthers) {
    test::Random random(4);
    auto region = blobs(random, 8);
    const auto all = region.hatched({}, 8);
    for (std::size_t i = 0; i < region.label.values.size(); ++i) {
        if (region.label.values[i] == 3) region.density.values[i] = 1.9F;
    }
    const auto changed = region.hatched({}, 8);
    EXPECT_NE(all.size(), changed.size());
    const auto others = [&](const std::vector<HatchStroke>& strokes) {
        std::vector<std::array<double, 4>> made;
        for (const auto& stroke : strokes) {
            const glm::dvec2 middle = 0.5 * (stroke.from + stroke.to);
            if (region.label.near(middle.x, middle.y) != 3)
                made.push_back({stroke.from.x, stroke.from.y, stroke.to.x, stroke.to.y});
        }
        return made;
    };
    EXPECT_EQ(others(all), others(changed));
}

TEST(Hatch, MoreInkIsNeverLessHatching) {
    double before = 0.0;
    for (int i = 0; i <= 60; ++i) {
        const double length = lengthOf(Region(80, 0.4F, i / 20.0).hatched({}));
        EXPECT_GE(length, before);
        before = length;
    }
    EXPECT_GT(before, 80.0 * 80.0 / 4.0 * 7.0);
}

TEST(Hatch, ExtremesDoNoHarm) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const double spacing : {1.0, 4.0, 31.7, 256.0}) {
        for (const double width : {0.1, 1.0, 64.0}) {
            for (const double wanted : {-infinity, -1.0, 0.0, 1e-30, 1.0, 1e30, infinity, -std::nan("")}) {
                Region region(48, static_cast<float>(spacing), wanted);
                if (wanted > 1.0) region.angle.values[7] = std::numeric_limits<float>::quiet_NaN();
                const HatchOptions options{.spacing = spacing, .width = width};
                EXPECT_TRUE(std::isfinite(mostHatched(options)) && mostHatched(options) > 0.0);
                const auto strokes = region.hatched(options);
                if (!(wanted > 0.0)) {
                    EXPECT_TRUE(strokes.empty());
                }
                EXPECT_LE(strokes.size(), 8U * 2U * 48U * 2U);
                for (const auto& stroke : strokes)
                    EXPECT_TRUE(std::isfinite(glm::dot(stroke.from, stroke.to)));
            }
        }
    }
    EXPECT_TRUE(Region(8, 0.0F, 1.0).hatched({}, 0).empty());
    EXPECT_EQ(Region(8, 0.0F, 1.0).hatched({}, 5).size(), Region(8, 0.0F, 1.0).hatched({}).size())
        << "no pixels";
    std::stop_source source;
    source.request_stop();
    const Region region(8, 0.0F, 1.0);
    const HatchRegions regions{region.label, 1, region.angle, region.density};
    EXPECT_TRUE(hatch(regions, hatchAxes(regions), {}, source.get_token()).empty());
}

}  // namespace
}  // namespace mote::render
