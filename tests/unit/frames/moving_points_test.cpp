// SPDX-License-Identifier: GPL-3.0-or-later
//
// Particles that both steps have move in a view between them (docs/PICTURE.md, "Between steps"): where they
// are then, that each is one and not two, and that light neither comes nor goes.
#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>

#include "tests/support/random.h"
#include "tests/unit/frames/between_steps_fixture.h"

namespace mote::server {
namespace {

using test::Random;

/// What a test knows of a run: where each particle is, by its id.
struct KnownRun {
    std::pair<Points, Points> points;
    std::pair<std::vector<std::uint64_t>, std::vector<std::uint64_t>> ids;
    std::map<std::uint64_t, glm::dvec3> first, second;

    void add(std::uint64_t id, const std::optional<glm::dvec3>& at, const std::optional<glm::dvec3>& then) {
        if (at) {
            points.first.push_back({*at});
            ids.first.push_back(id);
            first[id] = *at;
        }
        if (then) {
            points.second.push_back({*then});
            ids.second.push_back(id);
            second[id] = *then;
        }
    }
};

/// A cloud that turns, flattens and drifts; every `lone`-th particle is in one step alone.
KnownRun cloud(Random& random, std::size_t count, std::size_t lone = 0) {
    KnownRun run;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 off = 0.22 * random.between(0.1, 1.0) * random.direction();
        const glm::dvec3 at = inBox(glm::dvec3(0.35, 0.5, 0.5) + off);
        const glm::dvec3 then = inBox(glm::dvec3(0.65, 0.55, 0.5) + glm::dvec3(-off.y, 0.8 * off.x, off.z));
        const bool alone = lone > 0 && i % lone == 0;
        const bool before = alone && i % (2 * lone) == 0;
        run.add(1000 + 7 * i, alone && !before ? std::nullopt : std::optional(at),
                before ? std::nullopt : std::optional(then));
    }
    return run;
}

/// docs/PICTURE.md, "Between steps": all particles of a run along one axis.
struct KnownSwing {
    double angle = 0.0, mean[2] = {}, deviation[2] = {};

    double at(double share, double from, double to) const {
        if (angle == 0.0) return (1.0 - share) * from + share * to;
        const double u = (from - mean[0]) / deviation[0], v = (to - mean[1]) / deviation[1];
        const double both =
            (std::sin((1.0 - share) * angle) * u + std::sin(share * angle) * v) / std::sin(angle);
        const auto even = [share](const double(&ends)[2]) {
            return (1.0 - share) * ends[0] + share * ends[1];
        };
        return even(mean) + even(deviation) * both;
    }
};

std::array<KnownSwing, 3> swingsOf(const KnownRun& run) {
    std::array<KnownSwing, 3> swings;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> from, to;
        for (const auto& [id, place] : run.first) {
            if (run.second.count(id) == 0) continue;
            from.push_back(place[axis]);
            to.push_back(run.second.at(id)[axis]);
        }
        if (from.size() < 1000) continue;
        const auto meanOf = [&](const std::vector<double>& a, const std::vector<double>& b) {
            return std::inner_product(a.begin(), a.end(), b.begin(), 0.0) / static_cast<double>(a.size());
        };
        const std::vector<double> one(from.size(), 1.0);
        auto& [angle, mean, deviation] = swings[static_cast<std::size_t>(axis)];
        mean[0] = meanOf(from, one);
        mean[1] = meanOf(to, one);
        deviation[0] = std::sqrt(meanOf(from, from) - mean[0] * mean[0]);
        deviation[1] = std::sqrt(meanOf(to, to) - mean[1] * mean[1]);
        const double alike = (meanOf(from, to) - mean[0] * mean[1]) / (deviation[0] * deviation[1]);
        angle = alike < 1.0 - 1e-6 ? std::acos(alike) : 0.0;
    }
    return swings;
}

class MovingPoints : public BetweenSteps {
  protected:
    void addMoving(const KnownRun& run, const std::string& name = "run") {
        addRun(run.points, name, run.ids);
    }

    /// As a reference is told it: from the ids and places that the run was made of.
    reference::MovedPlace placesOf(const KnownRun& run) const {
        return [this, &run, swings = swingsOf(run)](const Layer& layer, std::uint64_t point,
                                                    const glm::dvec3& place) {
            const auto row = source_.steps("run")[layer.step]->rows(point, 1)[0];
            const auto id = (layer.step == 0 ? run.ids.first : run.ids.second)[row];
            if (run.first.count(id) + run.second.count(id) < 2) return place;
            const double share = layer.step == 0 ? layer.towards->share : 1.0 - layer.towards->share;
            glm::dvec3 there;
            for (int axis = 0; axis < 3; ++axis)
                there[axis] = swings[axis].at(share, run.first.at(id)[axis], run.second.at(id)[axis]);
            return 2.0 * there - 1.0;
        };
    }
};

INSTANTIATE_TEST_SUITE_P(Devices, MovingPoints, testing::Values("cpu", "egl"));

const std::string pointsAlone =
    "{'volume': {'curve': [{'density': 0, 'opacity': 0}]},"
    "'points': {'linked': false, 'curve': [{'density': 0, 'fraction': 1}], 'opacity': 0.5, 'sizePixels': 1}}";

/// Of the light, in pixels.
glm::dvec2 centroid(const Light& light) {
    glm::dvec2 sum(0.0);
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x)
            sum += luminance(light[std::size_t{y} * width + x]) * glm::dvec2(x + 0.5, y + 0.5);
    return sum / total(light);
}

std::size_t litPixels(const Light& light) {
    return static_cast<std::size_t>(
        std::ranges::count_if(light, [](const auto& pixel) { return luminance(pixel) > 1e-3; }));
}

TEST_P(MovingPoints, ALoneParticleIsOneDotOfFullLightOnItsWay) {
    KnownRun run;
    run.add(7, glm::dvec3(0.2, 0.3, 0.5), glm::dvec3(0.7, 0.8, 0.5));
    addMoving(run);
    const Light begin =
        lightOf(drawn(viewBetween(0.0, pointsAlone), Stage::exact, render::PixelFormat::linearHalf));
    const Light end =
        lightOf(drawn(viewBetween(1.0, pointsAlone), Stage::exact, render::PixelFormat::linearHalf));
    ASSERT_EQ(litPixels(begin), 1U);
    for (const double share : {0.125, 0.5, 0.8}) {
        const Light light =
            lightOf(drawn(viewBetween(share, pointsAlone), Stage::exact, render::PixelFormat::linearHalf));
        EXPECT_EQ(litPixels(light), 1U) << share;
        EXPECT_NEAR(total(light), total(begin), 0.002 * total(begin)) << share;
        // The middle of a pixel is told; the plot's depth is even here.
        const glm::dvec2 expected = (1.0 - share) * centroid(begin) + share * centroid(end);
        EXPECT_LT(glm::length(centroid(light) - expected), 1.5) << share;
    }
}

TEST_P(MovingPoints, WhatOneStepAloneHasFadesWhereItIs) {
    KnownRun run;
    run.add(1, glm::dvec3(0.3, 0.3, 0.5), std::nullopt);
    run.add(2, std::nullopt, glm::dvec3(0.7, 0.7, 0.5));
    run.add(3, glm::dvec3(0.3, 0.7, 0.5), glm::dvec3(0.3, 0.7, 0.5));
    addMoving(run);
    const auto lit = [&](double share) {
        return lightOf(drawn(viewBetween(share, pointsAlone), Stage::exact, render::PixelFormat::linearHalf));
    };
    const Light begin = lit(0.0), end = lit(1.0), between = lit(0.25);
    for (std::size_t i = 0; i < begin.size(); ++i)
        EXPECT_NEAR(luminance(between[i]), 0.75 * luminance(begin[i]) + 0.25 * luminance(end[i]), 2e-3);
}

TEST_P(MovingPoints, LightIsTheMeanOfBothEndsAndItsCentreMoves) {
    Random random(71);
    // So pale that what hides what is all one: where clouds part, less is hidden.
    std::string pale = pointsAlone;
    pale.replace(pale.find("0.5"), 3, "0.02");
    for (const std::size_t lone : {std::size_t{0}, std::size_t{4}}) {
        addMoving(cloud(random, 1500, lone));
        for (const auto stage : {Stage::exact, Stage::quick}) {
            std::vector<Light> lights;
            for (int i = 0; i <= 10; ++i) {
                lights.push_back(lightOf(drawn(
                    viewBetween(i / 10.0, pale), stage,
                    stage == Stage::exact ? render::PixelFormat::linearHalf : render::PixelFormat::srgb8)));
                ASSERT_EQ(lights.back().size(), std::size_t{width} * height);
            }
            for (int i = 1; i < 10; ++i) {
                const double share = i / 10.0;
                const double mean = (1.0 - share) * total(lights[0]) + share * total(lights[10]);
                const Light& light = lights[static_cast<std::size_t>(i)];
                EXPECT_NEAR(total(light), mean, 0.02 * mean) << lone << ' ' << share;
                const glm::dvec2 expected =
                    (1.0 - share) * centroid(lights[0]) + share * centroid(lights[10]);
                EXPECT_LT(glm::length(centroid(light) - expected), 1.0) << lone << ' ' << share;
            }
        }
    }
}

TEST_P(MovingPoints, NothingPopsInThirtyFrames) {
    Random random(72);
    addMoving(cloud(random, 3000, 5));
    for (const std::string& style : {std::string("{}"), withVolume}) {
        Light last = lightOf(drawn(viewBetween(0.0, style)));
        for (int frame = 1; frame <= 30; ++frame) {
            const Light next = lightOf(drawn(viewBetween(frame / 30.0, style)));
            for (const auto& measure : {total, brightestPatch}) {
                const double ratio = measure(next) / measure(last);
                EXPECT_LT(std::max(ratio, 1.0 / ratio), 1.3) << frame;
            }
            last = next;
        }
    }
}

TEST_P(MovingPoints, IsWhatTheReferenceSays) {
    Random random(73);
    // Few go straight, many as one body.
    for (const std::size_t count : {std::size_t{900}, std::size_t{1500}}) {
        const KnownRun run = cloud(random, count, 6);
        addMoving(run);
        for (const std::string& style : {std::string("{}"), withVolume, pointsAlone}) {
            for (const double share : {0.1, 0.5, 0.875}) {
                View view = viewBetween(share, style);
                EXPECT_GT(psnr(view, drawn(view), placesOf(run)), 45.0) << share;
                // From the later step to the earlier one it is the same way.
                View back = view;
                back.layers[0].step = 1;
                back.layers[0].towards = Towards{0, 1.0 - share};
                EXPECT_GT(psnr(back, drawn(back), placesOf(run)), 45.0) << share;
                view.layers[0].highlight = Highlight{};
                EXPECT_GT(psnr(view, drawn(view), placesOf(run)), 45.0) << share << ", highlighted";
            }
        }
        const View view = viewBetween(0.5, pointsAlone);
        EXPECT_LT(psnr(view, drawn(view)), 35.0) << "that they move is seen";
    }
}

TEST_P(MovingPoints, AtBothEndsItIsTheStepToTheLastByte) {
    Random random(74);
    addMoving(cloud(random, 500, 5));
    for (const double share : {0.0, 1.0}) {
        View plain = viewBetween(0.0);
        plain.layers[0].step = share == 0.0 ? 0 : 1;
        plain.layers[0].towards.reset();
        EXPECT_EQ(drawn(viewBetween(share)).pixels, drawn(plain).pixels);
    }
}

TEST_P(MovingPoints, WhatIdsDoNotTellOrThereIsNoRoomForDissolves) {
    Random random(75);
    KnownRun run = cloud(random, 300);
    addRun(run.points, "without");
    addMoving(run);
    std::ranges::fill(run.ids.first, 5);
    addMoving(run, "alike");
    View view = viewBetween(0.5, pointsAlone);
    const auto moved = drawn(view).pixels;
    const auto of = [&](const std::string& name) {
        View other = view;
        other.layers[0].dataset = name;
        return drawn(other).pixels;
    };
    const auto dissolved = of("without");
    EXPECT_NE(moved, dissolved);
    EXPECT_EQ(of("alike"), dissolved);
    source_.noRoom = true;
    EXPECT_EQ(of("run"), dissolved);
}

TEST_P(MovingPoints, APictureAtRestWaitsForTheWaysAndOneInMotionDoesNot) {
    Random random(76);
    addMoving(cloud(random, 300));
    source_.waits = true;
    const View view = viewBetween(0.5, pointsAlone);
    const auto rest = make(view);
    ASSERT_TRUE(rest.ok());
    EXPECT_TRUE(rest->waits);
    EXPECT_FALSE(rest->picture);
    const auto motion = make(view, Stage::quick);
    ASSERT_TRUE(motion.ok());
    EXPECT_TRUE(motion->picture);
}

}  // namespace
}  // namespace mote::server
