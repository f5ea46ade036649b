// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/select_points.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "storage/numbers/polygon_index.h"
#include "storage/numbers/range_kernel.h"
#include "tests/support/any_selection.h"
#include "tests/support/memory_run.h"
#include "tests/unit/numbers/plain_selection.h"

namespace mote::test {
namespace {

using storage::PointMask;
using storage::selectPoints;

SelectionShape shapeOf(const AnyRun& run) {
    SelectionShape shape;
    shape.columns = {{"x", -2e-3, 2e-3},  {"y", -2e-3, 2e-3},     {"z", 4.998, 5.002},
                     {"px", -2e4, 2e4},   {"pz", 3.98e6, 4.02e6}, {"r", 0.0, 3e-3},
                     {"xp", -5e-3, 5e-3}, {"delta", -1e-2, 1e-2}, {"energy", 3.4e6, 3.6e6}};
    shape.ids = run.ids ? run.most : 0;
    shape.steps = run.ids ? run.steps : 0;
    shape.nothing = true;
    return shape;
}

void expectSame(const PointMask& mask, const std::vector<Chosen>& expected, const std::string& what) {
    ASSERT_EQ(mask.size(), expected.size()) << what;
    std::uint64_t doubtful = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (expected[i] == Chosen::doubt)
            ++doubtful;
        else
            ASSERT_EQ(mask.chosen(i), expected[i] == Chosen::yes) << what << ", point " << i;
    }
    // Of a step that is flat in the plane, all emittances are alike.
    if (doubtful > 2 + expected.size() / 100) GTEST_LOG_(INFO) << what << ": " << doubtful << " in doubt";
    if (mask.size() % 64 != 0) {
        EXPECT_EQ(mask.words().back() >> (mask.size() % 64), 0U) << what;
    }
}

TEST(SelectPoints, HoldsWhatAPlainLoopFinds) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        Random random(seed, 71);
        AnyRun shape;
        shape.ids = random.chance(0.8);
        const auto run = anyRun(random, shape);
        for (int i = 0; i < 12; ++i) {
            const auto selection = anySelection(random, shapeOf(shape));
            const auto step = static_cast<std::uint32_t>(random.below(shape.steps));
            const auto mask = selectPoints(selection, *run, step, {});
            const auto what =
                std::to_string(seed) + "/" + std::to_string(i) + ": " + toProto(selection).ShortDebugString();
            ASSERT_TRUE(mask.ok()) << mask.error().toString() << what;
            expectSame(*mask, plainSelection(selection, *run, step), what);
        }
    }
}

TEST(SelectPoints, AnyNumberOfThreadsGivesTheSame) {
    Random random(5, 72);
    AnyRun shape;
    shape.most = 60000;
    const auto run = anyRun(random, shape);
    for (int i = 0; i < 20; ++i) {
        const auto selection = anySelection(random, shapeOf(shape));
        std::optional<PointMask> first;
        for (const int threads : {1, 2, 7}) {
            tbb::task_arena arena(threads);
            const auto mask = arena.execute([&] { return selectPoints(selection, *run, 0, {}); });
            ASSERT_TRUE(mask.ok());
            if (first)
                EXPECT_EQ(*mask, *first);
            else
                first = *mask;
        }
    }
}

TEST(SelectPoints, NoColumnsAreNeededWhereNoneAreNamed) {
    Random random(1, 73);
    const auto full = anyRun(random, {.most = 1000, .steps = 1});
    const MemoryRun run({{full->at(0).points, nullptr}}, {});
    Selection density;
    density.density = Selection::Density{0.2, 0.7};
    const auto mask = selectPoints(density, run, 0, {});
    ASSERT_TRUE(mask.ok());
    expectSame(*mask, plainSelection(density, run, 0), "density");
    Selection named;
    named.any.resize(2);
    named.any[1].ranges.push_back({"x"});
    const auto missing = selectPoints(named, run, 0, {});
    ASSERT_FALSE(missing.ok());
    EXPECT_EQ(missing.error().code, ErrorCode::notFound);
    EXPECT_EQ(missing.error().where, "any[1].ranges[0]");
    EXPECT_NE(missing.error().message.find("mote-prep particles"), std::string::npos);
}

TEST(SelectPoints, NothingIsNoParticleAndNotNothingIsAll) {
    Random random(3, 76);
    const auto run = anyRun(random, {.most = 5000, .steps = 2, .ids = true});
    const auto countOf = [&](const Selection& selection) {
        const auto mask = selectPoints(selection, *run, 0, {});
        EXPECT_TRUE(mask.ok());
        return mask.ok() ? mask->count() : 0;
    };
    const auto points = run->at(0).points->pointCount();
    Selection nothing, made, opposite, either, both;
    nothing.nothing = made.nothing = true;
    made.step = 1;  // no particle has no ids
    opposite.negated = {nothing};
    either.any = {nothing, Selection()};
    both.all = {nothing, Selection()};
    ASSERT_GT(points, 0U);
    EXPECT_EQ(countOf(Selection()), points);
    EXPECT_EQ(countOf(nothing), 0U);
    EXPECT_EQ(countOf(made), 0U);
    EXPECT_EQ(countOf(opposite), points);
    EXPECT_EQ(countOf(either), points);
    EXPECT_EQ(countOf(both), 0U);
}

TEST(SelectPoints, SaysWhatIsMissing) {
    Random random(1, 74);
    const auto run = anyRun(random, {.ids = false});
    const auto errorOf = [&](const Selection& selection) {
        const auto mask = selectPoints(selection, *run, 0, {});
        EXPECT_FALSE(mask.ok());
        return mask.ok() ? Error{} : mask.error();
    };
    Selection selection;
    selection.ranges = {{"x"}, {"charm"}};
    EXPECT_EQ(errorOf(selection).where, "ranges[1].column");
    EXPECT_NE(errorOf(selection).message.find("\"charm\""), std::string::npos);
    selection = {};
    selection.ids = {1};
    EXPECT_EQ(errorOf(selection).where, "ids");
    selection = {};
    selection.step = 1;
    EXPECT_EQ(errorOf(selection).where, "step");
    selection.step = 99;
    EXPECT_EQ(errorOf(selection).code, ErrorCode::notFound);
    EXPECT_EQ(errorOf(selection).where, "step");
    EXPECT_FALSE(selectPoints({}, *run, 7, {}).ok());
}

TEST(SelectPoints, StopsWhereItIsTold) {
    Random random(1, 75);
    auto run = anyRun(random, {.most = 50000, .steps = 1, .odd = false});
    while (run->at(0).points->pointCount() < 20000)
        run = anyRun(random, {.most = 50000, .steps = 1, .odd = false});
    Selection selection;
    selection.ranges.push_back({"r", 0.0, 1e-3});
    std::atomic<int> asked{0};
    const auto mask = selectPoints(selection, *run, 0, [&] { return ++asked > 1; });
    ASSERT_FALSE(mask.ok());
    EXPECT_EQ(mask.error().code, ErrorCode::cancelled);
}

TEST(PolygonIndex, IsAPlainLoop) {
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        Random random(seed, 76);
        const double scale = random.magnitude(-60, 60),
                     far = random.chance(0.3) ? scale * random.magnitude(0, 40) : 0.0;
        const auto most = random.oneOf<std::uint64_t>({3, 4, 9, 100, 3000});
        auto corners =
            anyPolygon(random, glm::dvec2(far - scale, -scale), glm::dvec2(far + scale, scale), most);
        if (random.chance(0.2)) {
            for (auto& corner : corners) corner = random.chance(0.5) ? corners[0] : corner;
        }
        const storage::PolygonIndex index(corners);
        for (int i = 0; i < 500; ++i) {
            glm::dvec2 place(random.between(far - 1.1 * scale, far + 1.1 * scale),
                             random.between(-1.1, 1.1) * scale);
            const auto corner = corners[random.below(corners.size())];
            if (random.chance(0.3)) place.x = corner.x;
            if (random.chance(0.3)) place.y = corner.y;
            if (random.chance(0.1)) place = 0.5 * (corner + corners[random.below(corners.size())]);
            ASSERT_EQ(index.contains(place.x, place.y), plainInside(corners, place.x, place.y))
                << seed << ": " << place.x << ", " << place.y;
        }
        const double nan = std::nan("");
        EXPECT_FALSE(index.contains(nan, 0.0) || index.contains(far, nan) || index.contains(INFINITY, 0.0));
    }
}

TEST(PolygonIndex, ManyCorners) {
    Random random(3, 77);
    std::vector<glm::dvec2> circle;
    constexpr std::size_t count = 100000;
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = glm::two_pi<double>() * static_cast<double>(i) / count;
        circle.push_back((1.0 + 0.01 * random.unit()) * glm::dvec2(std::cos(angle), std::sin(angle)));
    }
    const storage::PolygonIndex index(circle);
    for (int i = 0; i < 300; ++i) {
        const auto place = random.between(0.98, 1.02) * glm::dvec2(random.direction());
        EXPECT_EQ(index.contains(place.x, place.y), plainInside(circle, place.x, place.y));
    }
    EXPECT_TRUE(index.contains(0.0, 0.0));
    EXPECT_LE(index.bytes(), std::uint64_t{100} << 20);
}

TEST(RangeKernel, IsAComparisonOfDoubles) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        Random random(seed, 78);
        std::vector<float> values(random.below(300));
        for (auto& value : values) {
            value = static_cast<float>(random.sign() * random.magnitude(-20, 20));
            if (random.chance(0.05)) value = NAN;
            if (random.chance(0.05)) value = random.chance(0.5) ? 0.0F : -0.0F;
        }
        const double offset = random.chance(0.3) ? 0.0 : random.sign() * random.magnitude(-30, 40);
        const auto bound = [&](double none) {
            if (random.chance(0.2)) return none;
            const double value =
                values.empty() ? NAN : static_cast<double>(values[random.below(values.size())]);
            if (random.chance(0.5) && !std::isnan(value)) return offset + value;
            return offset + random.sign() * random.magnitude(-20, 20);
        };
        const double low = bound(-INFINITY), high = bound(INFINITY);
        std::vector<std::uint64_t> words((values.size() + 63) / 64);
        for (auto& word : words) word = random.chance(0.2) ? 0 : random.next();
        const auto before = words;
        storage::keepInRange(values, storage::floatRange(offset, low, high), words);
        for (std::size_t i = 0; i < values.size(); ++i) {
            const double value = offset + static_cast<double>(values[i]);
            const bool expected = (before[i / 64] >> (i % 64) & 1) != 0 && value >= low && value <= high;
            ASSERT_EQ((words[i / 64] >> (i % 64) & 1) != 0, expected) << seed << ": " << value;
        }
    }
}

}  // namespace
}  // namespace mote::test
