// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/step_ways.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "server/render/plan/moved_points.h"
#include "storage/numbers/point_places.h"
#include "storage/particles/selected_step.h"
#include "tests/support/memory_run.h"

namespace mote::render {
namespace {

using test::MemoryColumns, test::MemoryRun, test::MemoryStep, test::Random;

glm::dvec3 placeOf(const storage::ParticleStep& step, std::uint64_t point) {
    const storage::LeafWalk walk(step);
    return 0.5 * (walk.cell(walk.leafOf(point)).at(step.positions(point, 1)[0]) + 1.0);
}

/// Points of a step by the ids that one of them alone has.
std::map<std::uint64_t, std::uint64_t> loneIds(const MemoryRun& run, std::uint32_t step) {
    std::map<std::uint64_t, int> counts;
    std::map<std::uint64_t, std::uint64_t> points;
    const auto& columns = *run.at(step).columns;
    for (std::uint64_t i = 0; i < columns.pointCount(); ++i) {
        const auto id = columns.ids(i, 1)[0];
        ++counts[id];
        points[id] = i;
    }
    std::erase_if(points, [&](const auto& one) { return counts[one.first] > 1; });
    return points;
}

TEST(StepWays, PartnersAreThoseOfTheSameLoneId) {
    Random random(81);
    std::uint64_t found = 0;
    for (int i = 0; i < 30; ++i) {
        const auto run = test::anyRun(random, {.most = 400, .steps = 2});
        const auto ways = stepWays(*run, 0, 1, {}).value();
        const auto first = loneIds(*run, 0), second = loneIds(*run, 1);
        std::uint64_t both = 0;
        for (const auto& [id, point] : first) both += second.count(id);
        EXPECT_EQ(ways->moving, both);
        found += both;
        const auto check = [&](const PointWays& of, std::uint32_t step, const auto& here, const auto& there) {
            const auto& columns = *run->at(step).columns;
            ASSERT_EQ(of.ends.size(), columns.pointCount());
            for (std::uint64_t point = 0; point < of.ends.size(); ++point) {
                const auto id = columns.ids(point, 1)[0];
                const bool moves = here.count(id) > 0 && there.count(id) > 0;
                ASSERT_EQ(moves, !std::isnan(of.ends[point].x));
                if (!moves) continue;
                const auto end = placeOf(*run->at(1 - step).points, there.at(id));
                EXPECT_LT(glm::length(glm::dvec3(of.ends[point]) - end), 1e-6);
            }
        };
        check(ways->there, 0, first, second);
        check(ways->back, 1, second, first);
        EXPECT_TRUE(ways->there.bends.empty()) << "its axes are not told";
    }
    EXPECT_GT(found, 300U);
}

TEST(StepWays, WithoutIdsThereAreNone) {
    Random random(82);
    const auto run = test::anyRun(random, {.most = 50, .steps = 2, .ids = false});
    const auto ways = stepWays(*run, 0, 1, {});
    ASSERT_FALSE(ways.ok());
    EXPECT_EQ(ways.error().code, ErrorCode::notFound);
    EXPECT_EQ(stepWays(*test::anyRun(random), 0, 1, [] { return true; }).error().code, ErrorCode::cancelled);
}

constexpr double mass = 0.511e6, light = 299792458.0, span = 2.0;  // of each axis, m

proto::Axis axis(const std::string& name, const std::string& unit = "m") {
    proto::Axis made;
    made.set_name(name);
    made.set_unit(unit);
    made.set_min(-0.5 * span);
    made.set_max(0.5 * span);
    return made;
}

/// Where a particle is, and its speed over light's, at both steps, of the three axes.
struct Motion {
    glm::dvec3 place, speed;
};
using Motions = std::vector<std::pair<Motion, Motion>>;

/// Steps lie 1 ns apart.
std::shared_ptr<const MemoryRun> runOf(const Motions& motions, std::vector<proto::Axis> axes,
                                       std::uint8_t level = 10) {
    std::vector<MemoryRun::Step> steps;
    for (int i = 0; i < 2; ++i) {
        std::vector<test::WeightedPoint> points;
        const auto at = [&](std::uint64_t row) { return i == 0 ? motions[row].first : motions[row].second; };
        for (std::uint64_t row = 0; row < motions.size(); ++row)
            points.push_back({at(row).place / span + 0.5});
        MemoryRun::Step step{MemoryStep::make(points, {.leafCapacity = 16, .maxLevel = level}), {}};
        std::vector<MemoryColumns::Column> columns;
        std::vector<std::uint64_t> ids;
        for (int k = 0; k < 3; ++k) {
            MemoryColumns::Column column{{std::string("p") + "xyz"[k], "eV/c"}, {}};
            for (const auto row : step.points->rows(0, points.size())) {
                const auto& speed = at(row).speed;
                const double gamma = 1.0 / std::sqrt(1.0 - glm::dot(speed, speed));
                column.values.push_back(static_cast<float>(gamma * mass * speed[k]));
            }
            columns.push_back(std::move(column));
        }
        for (const auto row : step.points->rows(0, points.size())) ids.push_back(3 * row);
        step.columns =
            std::make_shared<const MemoryColumns>(points.size(), std::move(columns), std::move(ids));
        steps.push_back(std::move(step));
    }
    return std::make_shared<const MemoryRun>(std::move(steps), storage::BeamContext{mass, 0.0},
                                             std::move(axes));
}

/// Particles that swing, by so many radians from step to step.
Motions swinging(Random& random, double phase, int count = 300) {
    Motions motions;
    for (int i = 0; i < count; ++i) {
        const double start = random.between(0.0, 2.0 * std::numbers::pi);
        const glm::dvec3 far = std::min(1.0, 1.0 / phase) *
                               glm::dvec3(random.between(0.05, 0.2), random.between(0.05, 0.2), 0.0);
        const auto at = [&](double angle) {
            const double speed = phase / (light * 1e-9);
            return Motion{{far.x * std::cos(angle), far.y * std::sin(angle), 0.1},
                          {-far.x * speed * std::sin(angle), far.y * speed * std::cos(angle), 0.0}};
        };
        motions.emplace_back(at(start), at(start + phase));
    }
    return motions;
}

/// The greatest distance between where a point is half way and the curve that it swings on, over that of the
/// straight way.
double curveMissed(const Motions& motions, const MemoryRun& run, double phase) {
    const auto ways = stepWays(run, 0, 1, {}).value();
    double curve = 0.0, straight = 0.0;
    const auto& points = *run.at(0).points;
    for (std::uint64_t point = 0; point < motions.size(); ++point) {
        const auto& [first, second] = motions[points.rows(point, 1)[0]];
        // cos(a + b/2) = (cos(a) + cos(a + b)) / (2 cos(b/2)).
        const glm::dvec3 middle =
            glm::dvec3(glm::dvec2(first.place + second.place) / (2.0 * std::cos(0.5 * phase)), first.place.z);
        const auto place = placeOf(points, point);
        const auto there = span * (PlacesOnTheWay(ways->there, 0.5)(point, place) - 0.5);
        curve = std::max(curve, glm::length(there - middle));
        straight = std::max(straight, glm::length(0.5 * (first.place + second.place) - middle));
    }
    return curve / straight;
}

TEST(StepWays, MomentaBendTheWay) {
    Random random(83);
    for (const double phase : {0.3, 0.8, 1.2}) {
        const auto motions = swinging(random, phase);
        const auto run = runOf(motions, {axis("x"), axis("y"), axis("z")});
        EXPECT_LT(curveMissed(motions, *run, phase), 0.15) << phase;
        const auto ways = stepWays(*run, 0, 1, {}).value();
        const auto other = stepWays(*run, 1, 0, {}).value();
        for (std::uint64_t point = 0; point < motions.size(); ++point) {
            const auto place = placeOf(*run->at(1).points, point);
            EXPECT_LT(glm::length(PlacesOnTheWay(ways->back, 0.3)(point, place) -
                                  PlacesOnTheWay(other->there, 0.3)(point, place)),
                      1e-5)
                << "the way back is the same one";
        }
    }
}

/// Hermite's cubic is the only one of its ends and tangents, so any cubic is its own at every share.
TEST(StepWays, ABentWayIsTheCubicOfItsTangents) {
    constexpr double unit = 1.0 / 1024;  // of numbers that floats hold exactly
    const glm::dvec3 begin(0.25, 0.5, 0.125), slope(96 * unit, -40 * unit, 0.0),
        square(32 * unit, 8 * unit, -64 * unit), cube(-16 * unit, 72 * unit, 24 * unit);
    const auto place = [&](double s) { return begin + s * (slope + s * (square + s * cube)); };
    const glm::dvec3 straight = place(1.0) - begin;
    const glm::dvec3 first = (slope - straight) / unit;
    const glm::dvec3 last = (slope + 2.0 * square + 3.0 * cube - straight) / unit;
    PointWays ways{{glm::vec3(place(1.0))}};
    ways.unit = static_cast<float>(unit);
    PointWays::Bend bend{};
    for (int axis = 0; axis < 3; ++axis) {
        bend[static_cast<std::size_t>(axis)] = static_cast<std::int16_t>(first[axis]);
        bend[static_cast<std::size_t>(axis) + 3] = static_cast<std::int16_t>(last[axis]);
    }
    ways.bends = {bend};
    for (const double share : {0.0, 0.1, 0.25, 0.5, 0.8, 1.0})
        EXPECT_LT(glm::distance(PlacesOnTheWay(ways, share)(0, begin), place(share)), 1e-12) << share;
}

TEST(StepWays, MomentaThatDoNotTellTheWayDoNotBendIt) {
    Random random(84);
    const auto straight = [](const Motions& motions, std::vector<proto::Axis> axes) {
        return stepWays(*runOf(motions, std::move(axes)), 0, 1, {}).value()->there.bends.empty();
    };
    const std::vector<proto::Axis> places{axis("x"), axis("y"), axis("z")};
    EXPECT_TRUE(straight(swinging(random, 7.0), places)) << "more than once around";
    EXPECT_TRUE(straight(swinging(random, 0.8), {axis("px", "eV/c"), axis("delta", "1"), axis("t", "s")}));
    auto motions = swinging(random, 0.8);
    for (auto& [first, second] : motions) first.speed.z = second.speed.z = 0.9;
    const auto ways = stepWays(*runOf(motions, places), 0, 1, {}).value();
    for (const auto& bend : ways->there.bends) {
        EXPECT_EQ(bend[2], 0) << "z stands still, as in the beam's own frame";
        EXPECT_EQ(bend[5], 0);
    }
}

/// Of a phase space, momenta do not tell the way; that particles swing is seen of all of them together.
TEST(StepWays, ManySwingAsOneBody) {
    Random random(87);
    const std::vector<proto::Axis> axes{axis("x", "1"), axis("px", "1"), axis("y", "1")};
    for (const double phase : {0.4, 1.2, 1.9}) {
        const auto motions = swinging(random, phase, 4000);
        EXPECT_LT(curveMissed(motions, *runOf(motions, axes), phase), 0.15) << phase;
    }
    const auto far = stepWays(*runOf(swinging(random, 2.5, 4000), axes), 0, 1, {}).value();
    EXPECT_EQ(far->moving, 0U) << "they may have gone either way round";
    EXPECT_TRUE(far->swung);
    const auto few = stepWays(*runOf(swinging(random, 2.5), axes), 0, 1, {}).value();
    EXPECT_EQ(few->moving, 300U) << "who says nothing of each other go straight";
    EXPECT_EQ(few->there.swings[0].angle, 0.0);
}

TEST(StepWays, WhatGoesAroundAnAngleDoesNotCrossThePlot) {
    auto angle = axis("theta", "rad");
    angle.set_min(-std::numbers::pi);
    angle.set_max(std::numbers::pi);
    // Places of this plot are parts of 2.
    const Motions motions{{{{0.0, 0.0, 0.95}, {}}, {{0.0, 0.0, -0.95}, {}}},
                          {{{0.1, 0.0, 0.3}, {}}, {{0.1, 0.0, -0.3}, {}}}};
    const auto run = runOf(motions, {axis("x"), axis("y"), angle});
    const auto ways = stepWays(*run, 0, 1, {}).value();
    EXPECT_EQ(ways->moving, 1U);
    for (std::uint64_t point = 0; point < 2; ++point)
        EXPECT_EQ(std::isnan(ways->there.ends[point].x), run->at(0).points->rows(point, 1)[0] == 0);
}

/// Sorted, as moved points have another order.
std::vector<glm::dvec3> sorted(std::vector<glm::dvec3> places) {
    std::ranges::sort(places, [](const auto& a, const auto& b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    });
    return places;
}

TEST(MovedPoints, LieWhereTheirWaysAre) {
    Random random(85);
    const auto motions = swinging(random, 0.5);
    const auto run = runOf(motions, {axis("x"), axis("y"), axis("z")}, 12);
    const auto ways = stepWays(*run, 0, 1, {}).value();
    const auto& step = *run->at(0).points;
    PointSelection half;
    PointValues values;
    for (std::size_t leaf = 0; leaf < step.leaves().size(); ++leaf) {
        half.drawn.push_back((step.leaves().pointCount[leaf] + 1) / 2);
        half.weights.push_back(static_cast<std::uint16_t>(0x3f80 + leaf % 64));
        values.codes.push_back(static_cast<ValueCode>(leaf));
    }
    values.byLeaf = true;
    const auto moved = movePoints(step, &half, ways->there, 0.4, &values);
    std::vector<glm::dvec3> expected, found;
    for (std::size_t leaf = 0; leaf < half.drawn.size(); ++leaf) {
        for (std::uint32_t i = 0; i < half.drawn[leaf]; ++i) {
            const auto point = step.leaves().pointBegin[leaf] + i;
            expected.push_back(PlacesOnTheWay(ways->there, 0.4)(point, placeOf(step, point)));
        }
    }
    const auto leaves = moved.step->leaves();
    ASSERT_EQ(moved.selection->drawn.size(), leaves.size());
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        EXPECT_EQ(moved.selection->drawn[leaf], leaves.pointCount[leaf]);
        for (std::uint32_t i = 0; i < leaves.pointCount[leaf]; ++i) {
            const auto point = leaves.pointBegin[leaf] + i;
            found.push_back(placeOf(*moved.step, point));
            const auto from = moved.values->codes.at(point);
            EXPECT_EQ(moved.selection->weights[leaf], half.weights[from]) << "each weighs what it did";
        }
    }
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_EQ(moved.selection->points, found.size());
    // Neighbours may change places by a rounding, so the order is that of one axis at a time.
    for (int k = 0; k < 3; ++k) {
        std::ranges::sort(found, {}, [k](const auto& place) { return place[k]; });
        std::ranges::sort(expected, {}, [k](const auto& place) { return place[k]; });
        for (std::size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i][k], expected[i][k], 0x1p-19);
    }
}

TEST(MovedPoints, OfChosenPointsGoTheWaysOfTheStep) {
    Random random(86);
    const auto run = runOf(swinging(random, 0.5), {axis("x"), axis("y"), axis("z")});
    const auto ways = stepWays(*run, 0, 1, {}).value();
    const auto& step = *run->at(0).points;
    storage::PointMask mask(step.pointCount());
    std::vector<glm::dvec3> expected, found;
    for (std::uint64_t point = 0; point < step.pointCount(); point += 3) {
        mask.choose(point);
        expected.push_back(PlacesOnTheWay(ways->there, 1.0)(point, placeOf(step, point)));
    }
    const auto chosen = storage::SelectedStep::make(step, mask, 16, {}).value();
    const auto moved = movePoints(*chosen, nullptr, ways->there, 1.0, nullptr);
    for (std::uint64_t point = 0; point < moved.step->pointCount(); ++point)
        found.push_back(placeOf(*moved.step, point));
    ASSERT_EQ(found.size(), expected.size());
    found = sorted(found);
    expected = sorted(expected);
    for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_LT(glm::length(found[i] - expected[i]), 1e-4) << "ends are those of the other step";
}

TEST(MovedPoints, OfWhatIsCutThoseStayThatLieInAllHalfSpaces) {
    Random random(87);
    const auto run = runOf(swinging(random, 0.5), {axis("x"), axis("y"), axis("z")}, 12);
    const auto& step = *run->at(0).points;
    PointSelection half;
    PointValues values;
    for (std::size_t leaf = 0; leaf < step.leaves().size(); ++leaf) {
        half.drawn.push_back((step.leaves().pointCount[leaf] + 1) / 2);
        half.weights.push_back(static_cast<std::uint16_t>(0x3f80 + leaf % 64));
    }
    for (std::uint64_t point = 0; point < step.pointCount(); ++point)
        values.codes.push_back(static_cast<ValueCode>(point));
    const HalfSpaces clips{{glm::normalize(glm::dvec3(1.0, 2.0, -1.0)), -0.1}, {{-1.0, 0.0, 0.0}, -0.2}};
    const auto left = cutPoints(step, &half, clips, &values);
    std::size_t at = 0;
    for (std::size_t leaf = 0; leaf < half.drawn.size(); ++leaf) {
        for (std::uint32_t i = 0; i < half.drawn[leaf]; ++i) {
            const auto point = step.leaves().pointBegin[leaf] + i;
            const glm::dvec3 place = placeOf(step, point), inLayer = 2.0 * place - 1.0;
            if (inLayer.x > 0.2 || inLayer.x + 2.0 * inLayer.y - inLayer.z < -0.1 * std::sqrt(6.0)) continue;
            ASSERT_LT(at, left.step->pointCount());
            EXPECT_EQ(left.values->codes.at(at), values.codes[point]);
            EXPECT_EQ(placeOf(*left.step, at++), place) << "each stays where it is";
        }
    }
    EXPECT_GT(at, 10U);
    EXPECT_EQ(at, left.selection->points);
    EXPECT_EQ(at, left.step->pointCount());
    EXPECT_EQ(left.selection->weights.size(), left.step->leaves().size());
    const auto none = cutPoints(step, nullptr, {{{1.0, 0.0, 0.0}, 2.0}}, nullptr);
    EXPECT_EQ(none.step->pointCount(), 0U);
}

}  // namespace
}  // namespace mote::render
