// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views between steps, from a view to its picture (docs/PICTURE.md, "Between steps"): against the reference,
// and that light neither comes nor goes on the way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <numeric>

#include "protocol/scene/srgb.h"
#include "server/frames/picture_maker.h"
#include "server/render/device.h"
#include "tests/reference/between_steps.h"
#include "tests/support/random.h"
#include "tests/support/view_text.h"
#include "tests/unit/frames/memory_source.h"

namespace mote::server {
namespace {

using test::MemoryStep, test::Random, test::WeightedPoint;
using Points = std::vector<WeightedPoint>;

constexpr std::uint32_t width = 96, height = 72;

glm::dvec3 inBox(const glm::dvec3& place) {
    return glm::clamp(place, glm::dvec3(0.0), glm::dvec3(1.0 - 1e-9));
}

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

/// Linear light.
using Light = std::vector<glm::dvec3>;

Light lightOf(const render::Picture& picture) {
    Light light(std::size_t{picture.width} * picture.height);
    const bool half = picture.format == render::PixelFormat::linearHalf;
    for (std::size_t i = 0; i < light.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const std::size_t at = 4 * i + static_cast<std::size_t>(c);
            std::uint16_t bits = 0;
            if (half) std::memcpy(&bits, picture.pixels.data() + 2 * at, 2);
            light[i][c] = half ? glm::unpackHalf1x16(bits) : srgbToLinear(picture.pixels[at] / 255.0);
        }
    }
    return light;
}

double total(const Light& light) {
    return std::accumulate(light.begin(), light.end(), 0.0,
                           [](double sum, const auto& pixel) { return sum + luminance(pixel); });
}

/// Of the brightest 8 x 8 pixels.
double brightestPatch(const Light& light) {
    constexpr std::uint32_t side = 8;
    std::vector<double> patches(std::size_t{width / side} * (height / side));
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x)
            patches[y / side * (width / side) + x / side] += luminance(light[std::size_t{y} * width + x]);
    return *std::max_element(patches.begin(), patches.end());
}

class BetweenSteps : public testing::TestWithParam<const char*> {
  protected:
    static View viewBetween(double share, const std::string& style = "{}") {
        View view = test::viewOf(
            "{'width': 96, 'height': 72, 'camera': {'eye': [0.8, 0.6, 4], 'target': [0, 0, 0]},"
            "'layers': [{'dataset': 'run', 'particles': " +
            style + "}]}");
        view.layers[0].towards = Towards{1, share};
        return view;
    }
    void addRun(const std::pair<Points, Points>& run, const std::string& name = "run") {
        test::MemoryStepOptions options{.volumeLevel = 4};
        options.logDensity = MemoryStep::make(run.first, options)->logDensity();
        source_.add(name, {MemoryStep::make(run.first, options), MemoryStep::make(run.second, options)});
    }
    Result<Making> make(const View& view, Stage stage = Stage::exact,
                        render::PixelFormat format = render::PixelFormat::srgb8) {
        auto task = std::make_shared<ViewTask>();
        task->view = view;
        task->format = format;
        return maker_.make({.session = 1, .task = task, .stage = stage}, history_);
    }
    render::Picture drawn(const View& view, Stage stage = Stage::exact,
                          render::PixelFormat format = render::PixelFormat::srgb8) {
        auto made = make(view, stage, format);
        EXPECT_TRUE(made.ok()) << made.error().toString();
        EXPECT_TRUE(made.ok() && made->picture);
        return made.ok() && made->picture ? made->picture->picture : render::Picture();
    }
    /// As the frames of a view give it.
    render::Scene sceneOf(const View& view) const {
        render::Scene scene{view, {}};
        for (std::size_t i = 0; i < view.layers.size(); ++i) {
            resolveByPlot(*scene.view.layers[i].particles(), source_.plot(view.layers[i].dataset));
            scene.steps.push_back(source_.steps(view.layers[i].dataset)[view.layers[i].step]);
        }
        return scene;
    }
    double psnr(const View& view, const render::Picture& picture) const {
        const auto expected = reference::encode(
            reference::renderBetween(view, [this](const View& one) { return sceneOf(one); }));
        double squares = 0.0;
        for (std::size_t i = 0; i < expected.pixels.size(); ++i)
            squares += std::pow(expected.pixels[i] - picture.pixels[i], 2);
        return 10.0 *
               std::log10(255.0 * 255.0 * static_cast<double>(expected.pixels.size()) / (squares + 1e-9));
    }

    MemorySource source_;
    PictureMaker maker_{[] {
                            const auto kind = render::parseDeviceKind(GetParam());
                            return render::createDevice(kind.value(), 1);
                        },
                        source_, render::DeviceCosts{}};
    PictureHistory history_{QualityController(30.0)};
};

INSTANTIATE_TEST_SUITE_P(Devices, BetweenSteps, testing::Values("cpu", "egl"));

const std::string withVolume =
    "{'volume': {'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.3}]},"
    "'points': {'opacity': 0.7, 'sizePixels': 1.5}}";

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
