// SPDX-License-Identifier: GPL-3.0-or-later
//
// SelectedStep against plain loops over the chosen points, for masks and steps that nobody chose.
#include "storage/particles/selected_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "storage/numbers/point_places.h"
#include "storage/particles/octree_check.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/random.h"

namespace mote::test {
namespace {

using storage::PointMask;
using storage::SelectedStep;

constexpr std::uint32_t leafCapacity = 16;

std::shared_ptr<const MemoryStep> someStep(Random& random, bool evenWeights) {
    std::vector<WeightedPoint> points;
    const std::uint64_t count = random.oneOf({0U, 1U, 2U, 400U, 3000U});
    for (std::uint64_t i = 0; i < count; ++i) {
        // A dense corner within a thin cloud, and some in one place.
        const double scale = random.chance(0.5) ? 0.03 : 1.0;
        glm::dvec3 place = scale * glm::dvec3(random.unit(), random.unit(), random.unit());
        if (random.chance(0.02)) place = glm::dvec3(0.5);
        points.push_back({place, evenWeights ? 1.0 : random.magnitude(-2, 2)});
    }
    return MemoryStep::make(points, {.leafCapacity = leafCapacity,
                                     .maxLevel = random.oneOf<std::uint8_t>({2, 7, 16}),
                                     .volumeLevel = random.oneOf<std::uint8_t>({0, 3, 5}),
                                     .seed = random.next()});
}

PointMask someMask(Random& random, std::uint64_t points) {
    PointMask mask(points);
    const double share = random.oneOf({0.0, 0.01, 0.3, 0.97, 1.0});
    for (std::uint64_t i = 0; i < points; ++i) {
        if (random.chance(share) || share == 1.0) mask.choose(i);
    }
    return mask;
}

std::shared_ptr<const SelectedStep> selected(const storage::ParticleStep& step, const PointMask& mask) {
    auto made = SelectedStep::make(step, mask, leafCapacity, {});
    EXPECT_TRUE(made.ok());
    return *made;
}

std::vector<glm::dvec3> placesOf(const storage::ParticleStep& step) {
    std::vector<glm::dvec3> places;
    const storage::LeafWalk walk(step);
    for (std::size_t leaf = 0; leaf < step.leaves().size(); ++leaf) {
        const auto cell = walk.cell(leaf);
        for (const auto& p : step.positions(step.leaves().pointBegin[leaf], step.leaves().pointCount[leaf]))
            places.push_back(cell.at(p));
    }
    return places;
}

TEST(SelectedStep, HoldsTheChosenPointsInTheirPlacesInAnOctree) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        Random random(seed);
        const auto step = someStep(random, true);
        const auto mask = someMask(random, step->pointCount());
        const auto some = selected(*step, mask);
        ASSERT_EQ(some->pointCount(), mask.count()) << seed;
        const auto all = placesOf(*step), places = placesOf(*some);
        ASSERT_EQ(places.size(), some->sources().size());
        PointMask met(step->pointCount());
        for (std::size_t i = 0; i < places.size(); ++i) {
            EXPECT_EQ(places[i], all[some->sources()[i]]) << seed;
            met.choose(some->sources()[i]);
        }
        EXPECT_EQ(met, mask) << seed;
        if (mask.count() == 0) continue;  // a root without leaves
        EXPECT_TRUE(storage::checkOctree(some->nodes(), some->leaves(), some->pointCount(), 16).ok()) << seed;
    }
}

/// Points by the cell of a level that holds them.
using Cells = std::map<std::tuple<std::uint64_t, std::uint64_t, std::uint64_t>, std::uint64_t>;

Cells cellsOf(const std::vector<glm::dvec3>& places, int level) {
    Cells cells;
    for (const auto& place : places) {
        const auto at = [&](double x) {
            return static_cast<std::uint64_t>(std::ldexp(0.5 * (x + 1.0), level));
        };
        ++cells[{at(place.x), at(place.y), at(place.z)}];
    }
    return cells;
}

// Of points of one weight a density is a count over a cell's share of the box: of the largest cell around
// that holds no more of the chosen than a leaf may.
TEST(SelectedStep, HasTheDensitiesOfTheChosenAlone) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        Random random(seed, 1);
        const auto step = someStep(random, true);
        const auto some = selected(*step, someMask(random, step->pointCount()));
        const auto places = placesOf(*some);
        std::vector<Cells> levels;
        for (int level = 0; level <= 16; ++level) levels.push_back(cellsOf(places, level));
        const auto leaves = some->leaves();
        for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
            const glm::dvec3& place = places[leaves.pointBegin[leaf]];
            const int own = some->nodes().level[leaves.node[leaf]];
            for (int level = 0; level <= own; ++level) {
                const auto at = [&](double x) {
                    return static_cast<std::uint64_t>(std::ldexp(0.5 * (x + 1.0), level));
                };
                const auto count =
                    levels[static_cast<std::size_t>(level)].at({at(place.x), at(place.y), at(place.z)});
                if (count > leafCapacity && level < own) continue;
                const double expected = std::ldexp(static_cast<double>(count), 3 * level);
                EXPECT_NEAR(leaves.density[leaf], expected, 1e-5 * expected) << seed;
                break;
            }
        }
    }
}

TEST(SelectedStep, CountsTheVolumeFromTheChosen) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        Random random(seed, 2);
        const auto step = someStep(random, true);
        const auto some = selected(*step, someMask(random, step->pointCount()));
        const auto size = some->volumeSize();
        const auto cells = cellsOf(placesOf(*some), static_cast<int>(std::log2(size)));
        std::vector<double> expected(some->volume().size(), 0.0);
        for (const auto& [cell, count] : cells) {
            const auto& [x, y, z] = cell;
            expected[(z * size + y) * size + x] =
                static_cast<double>(count) * static_cast<double>(expected.size());
        }
        for (std::size_t i = 0; i < expected.size(); ++i)
            ASSERT_NEAR(some->volume()[i], expected[i], 1e-4 * expected[i] + 1e-6) << seed << ' ' << i;
    }
}

TEST(SelectedStep, IsTheStepWhereAllAreChosen) {
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        Random random(seed, 3);
        const auto step = someStep(random, false);
        PointMask mask(step->pointCount());
        for (std::uint64_t i = 0; i < mask.size(); ++i) mask.choose(i);
        const auto same = selected(*step, mask);
        const auto equal = [](auto a, auto b) { return std::equal(a.begin(), a.end(), b.begin(), b.end()); };
        EXPECT_TRUE(equal(same->nodes().morton, step->nodes().morton)) << seed;
        EXPECT_TRUE(equal(same->nodes().firstChild, step->nodes().firstChild)) << seed;
        EXPECT_TRUE(equal(same->leaves().node, step->leaves().node)) << seed;
        EXPECT_TRUE(equal(same->leaves().pointBegin, step->leaves().pointBegin)) << seed;
        EXPECT_TRUE(equal(same->leaves().density, step->leaves().density)) << seed;
        EXPECT_EQ(placesOf(*same), placesOf(*step)) << seed;
    }
}

TEST(SelectedStep, StopsWhenItIsTold) {
    Random random(7);
    std::vector<WeightedPoint> points;
    for (int i = 0; i < 1000; ++i) points.push_back({{random.unit(), random.unit(), random.unit()}, 1.0});
    const auto step = MemoryStep::make(points);
    const auto made = SelectedStep::make(*step, PointMask(1000), leafCapacity, [] { return true; });
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::test
