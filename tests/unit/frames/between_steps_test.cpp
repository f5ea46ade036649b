// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views between steps, from a view to its picture (docs/PICTURE.md, "Between steps"): against the reference,
// and that light neither comes nor goes on the way.
#include "tests/support/random.h"
#include "tests/unit/frames/between_steps_fixture.h"

namespace mote::server {
namespace {

using test::Random;

/// A bunch of particles around a line through the plot's middle.
Points bunch(Random& random, std::size_t count, const glm::dvec3& way, double thick) {
    Points points;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 off = thick * random.between(0.2, 2.0) * random.direction();
        points.push_back({inBox(glm::dvec3(0.5) + random.between(-0.4, 0.4) * way + off)});
    }
    return points;
}

/// Two steps of a run that nobody chose: particles that move, beams that cross, more particles or fewer, an
/// empty step.
std::pair<Points, Points> anyRun(Random& random, unsigned kind) {
    const auto count = static_cast<std::size_t>(random.magnitude(8, 13));
    const glm::dvec3 way = random.direction(), other = random.direction();
    const double thick = random.magnitude(-8, -3);
    const auto first = bunch(random, count, way, thick);
    if (kind == 0) {
        auto second = first;
        for (auto& point : second) point.position = inBox(point.position + 0.15 * other);
        return {first, second};
    }
    if (kind == 1) return {first, bunch(random, count, other, thick)};
    if (kind == 2) return {first, bunch(random, count / 9 + 1, other, 2.0 * thick)};
    return {first, {}};
}

INSTANTIATE_TEST_SUITE_P(Devices, BetweenSteps, testing::Values("cpu", "egl"));

TEST_P(BetweenSteps, LightIsTheMeanOfBothEndsAllTheWay) {
    Random random(51);
    for (unsigned kind = 0; kind < 4; ++kind) {
        for (const std::string& style : {std::string("{}"), withVolume}) {
            addRun(anyRun(random, kind));
            std::vector<double> exact, encoded;
            for (int i = 0; i <= 10; ++i) {
                const View view = viewBetween(i / 10.0, style);
                exact.push_back(total(lightOf(drawn(view, Stage::exact, render::PixelFormat::linearHalf))));
                encoded.push_back(total(lightOf(drawn(view))));
            }
            ASSERT_GT(exact[0], 1.0) << "something is seen";
            for (int i = 1; i < 10; ++i) {
                const double share = i / 10.0, mean = (1.0 - share) * exact[0] + share * exact[10];
                // Three roundings to 11 bits; steps of sRGB, which are coarse where it is dark.
                EXPECT_NEAR(exact[static_cast<std::size_t>(i)], mean, 0.001 * mean) << kind << ' ' << share;
                EXPECT_NEAR(encoded[static_cast<std::size_t>(i)],
                            (1.0 - share) * encoded[0] + share * encoded[10], 0.02 * mean)
                    << kind << ' ' << share;
            }
        }
    }
}

TEST_P(BetweenSteps, NothingPopsInThirtyFrames) {
    Random random(52);
    for (unsigned kind = 0; kind < 3; ++kind) {
        addRun(anyRun(random, kind));
        Light last = lightOf(drawn(viewBetween(0.0)));
        for (int frame = 1; frame <= 30; ++frame) {
            const Light next = lightOf(drawn(viewBetween(frame / 30.0)));
            for (const auto& measure : {total, brightestPatch}) {
                const double ratio = measure(next) / measure(last);
                EXPECT_LT(std::max(ratio, 1.0 / ratio), 1.3) << kind << ' ' << frame;
            }
            last = next;
        }
    }
}

TEST_P(BetweenSteps, AtBothEndsItIsTheStepToTheLastByte) {
    Random random(53);
    addRun(anyRun(random, 1));
    for (const auto format : {render::PixelFormat::srgb8, render::PixelFormat::linearHalf}) {
        for (const double share : {0.0, 1.0}) {
            View plain = viewBetween(0.0);
            plain.layers[0].step = share == 0.0 ? 0 : 1;
            plain.layers[0].towards.reset();
            EXPECT_EQ(drawn(viewBetween(share), Stage::exact, format).pixels,
                      drawn(plain, Stage::exact, format).pixels);
            plain.layers[0].towards = Towards{plain.layers[0].step, 0.3};
            EXPECT_EQ(drawn(plain, Stage::exact, format).pixels,
                      drawn(viewBetween(share), Stage::exact, format).pixels);
        }
    }
    // A step that is never shown is not asked for.
    source_.asked.clear();
    drawn(viewBetween(0.0));
    EXPECT_EQ(source_.asked, (std::vector<std::pair<std::string, std::uint32_t>>{{"run", 0}}));
}

TEST_P(BetweenSteps, IsWhatTheReferenceSays) {
    Random random(54);
    addRun(anyRun(random, 1));
    addRun(anyRun(random, 2), "other");
    for (const std::string& style : {std::string("{}"), withVolume}) {
        for (const double share : {0.1, 0.5, 0.875}) {
            View view = viewBetween(share, style);
            EXPECT_GT(psnr(view, drawn(view)), 45.0) << share;
            view.layers.push_back(view.layers[0]);
            view.layers[1].dataset = "other";
            view.layers[1].towards = Towards{1, 0.625};
            EXPECT_GT(psnr(view, drawn(view)), 45.0) << share;
            view.layers[1].towards->share = share;
            EXPECT_GT(psnr(view, drawn(view)), 45.0) << share << ", both at once";
        }
    }
}

TEST_P(BetweenSteps, EveryStageIsThere) {
    Random random(55);
    addRun(anyRun(random, 1));
    const View view = viewBetween(0.4);
    const double exact = total(lightOf(drawn(view)));
    for (const auto stage : {Stage::quick, Stage::intermediate}) {
        auto made = make(view, stage);
        ASSERT_TRUE(made.ok() && made->picture);
        const auto& picture = made->picture->picture;
        EXPECT_EQ(picture.format, render::PixelFormat::srgb8);
        const double pixels = static_cast<double>(picture.width) * picture.height;
        EXPECT_NEAR(total(lightOf(picture)) / pixels, exact / (width * height),
                    0.1 * exact / (width * height));
        EXPECT_NE(made->picture->next, Stage::done);
        EXPECT_FALSE(made->picture->message.final());
        EXPECT_EQ(made->picture->message.points_drawn(),
                  source_.steps("run")[0]->pointCount() + source_.steps("run")[1]->pointCount());
    }
}

/// Soft dots ask for it (Stage::quick after Stage::quick).
TEST_P(BetweenSteps, TheSameStageOfAViewMayComeTwice) {
    Random random(58);
    addRun(anyRun(random, 1));
    drawn(viewBetween(0.0));
    auto task = std::make_shared<ViewTask>();
    task->view = viewBetween(0.4);
    std::vector<std::uint8_t> first;
    for (int i = 0; i < 2; ++i) {
        auto made = maker_.make({.session = 1, .task = task, .stage = Stage::exact}, history_);
        ASSERT_TRUE(made.ok() && made->picture);
        if (i == 0) first = made->picture->picture.pixels;
        EXPECT_TRUE(history_.steps.empty()) << "no step of an earlier picture is kept for it";
        EXPECT_EQ(made->picture->picture.pixels, first);
    }
}

TEST_P(BetweenSteps, AStepThatIsNotThereIsAnErrorAtAnyShare) {
    Random random(56);
    addRun(anyRun(random, 0));
    for (const double share : {0.0, 0.5, 1.0}) {
        View view = viewBetween(share);
        view.layers[0].towards->step = 2;
        const auto made = make(view);
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::notFound);
        EXPECT_EQ(made.error().where, "layers[0].towards.step");
    }
}

TEST_P(BetweenSteps, OnAPageItIsAPictureAndForAPlotterAnError) {
    Random random(57);
    addRun(anyRun(random, 0));
    auto task = std::make_shared<ViewTask>();
    task->view = viewBetween(0.5);
    task->finalOnly = true;
    task->page = Page{};
    const auto made = maker_.make({.session = 1, .task = task, .stage = Stage::exact}, history_);
    ASSERT_TRUE(made.ok() && made->picture);
    EXPECT_FALSE(made->picture->onlyShapes);
    EXPECT_EQ(made->picture->picture.pixels, drawn(viewBetween(0.5)).pixels);
    auto plotted = std::make_shared<ViewTask>(*task);
    plotted->page->plotter = true;
    const auto refused = maker_.make({.session = 1, .task = plotted, .stage = Stage::exact}, history_);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace mote::server
