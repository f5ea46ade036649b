// SPDX-License-Identifier: GPL-3.0-or-later
//
// The camera that is fitted to particles: that of all points that may be seen, one by one.
#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "protocol/scene/particles_style.h"
#include "protocol/scene/view_message.h"
#include "server/frames/scene_maker.h"
#include "storage/numbers/point_places.h"
#include "tests/support/view_text.h"
#include "tests/unit/frames/memory_source.h"

namespace mote::server {
namespace {

std::shared_ptr<const test::MemoryStep> clustersOf(std::mt19937& dice) {
    std::uniform_real_distribution<double> part(0.0, 1.0);
    std::normal_distribution<double> about(0.0, 1.0);
    std::vector<test::WeightedPoint> points;
    const int clusters = 1 + static_cast<int>(4 * part(dice));
    for (int c = 0; c < clusters; ++c) {
        const glm::dvec3 middle(part(dice), part(dice), part(dice));
        const double width = std::exp(-6.0 * part(dice));
        for (int i = static_cast<int>(2000 * part(dice)); i > 0; --i) {
            const glm::dvec3 off(about(dice), about(dice), about(dice));
            points.push_back({glm::clamp(middle + 0.3 * width * off, 0.0, 1.0 - 1e-9), 1.0});
        }
    }
    return test::MemoryStep::make(points, {.leafCapacity = 1 + static_cast<std::uint32_t>(40 * part(dice))});
}

/// A curve that shows some densities, or none, and a clip.
std::string layerOf(std::mt19937& dice) {
    std::uniform_real_distribution<double> part(0.0, 1.0);
    const double from = part(dice) - 0.3, to = from + part(dice);
    const auto knots = [&](const char* what) {
        std::ostringstream text;
        const double a = std::clamp(from, 0.01, 0.97), b = std::clamp(to, a + 0.01, 0.99);
        text << "[{'density': 0, '" << what << "': " << (from < 0.0) << "}, {'density': " << a << ", '"
             << what << "': 0}, {'density': " << 0.5 * (a + b) << ", '" << what << "': 1}, {'density': " << b
             << ", '" << what << "': 0}]";
        return text.str();
    };
    std::ostringstream text;
    text << "{'dataset': 'test/beam', 'particles': {'volume': {'curve': " << knots("opacity")
         << "}, 'points': {'linked': false, 'curve': "
         << (part(dice) < 0.5 ? knots("fraction") : "[{'fraction': 0}]") << "}}";
    if (part(dice) < 0.5)
        text << ", 'clip': {'planes': [{'normal': [" << part(dice) - 0.5 << ", " << part(dice) - 0.5
             << ", 0.1], "
             << "'distance': " << 0.4 * (part(dice) - 0.5) << "}]}";
    text << "}";
    return text.str();
}

/// Of all points, in any order.
Camera cameraByHand(const View& view, MemorySource& source) {
    const Layer& layer = view.layers[0];
    const auto& step = *source.steps("test/beam")[0];
    auto style = particlesStyleOf(*layer.particles());
    resolveByPlot(style, source.plot("test/beam"), false);
    const storage::LeafWalk walk(step);
    CameraFit fit(outlookOf({}, layer.transform), fittedAspect(view), fitMargin(view).y);
    fit.enter(layer.transform, layer.clips());
    for (std::size_t i = 0; i < walk.leaves().size(); ++i) {
        const double t = step.logDensity().ofLeaf(static_cast<double>(walk.leaves().density[i]));
        if (style.pointFraction(t) <= 0.0 && style.volumeOpacity(t) <= 0.0) continue;
        for (const auto& point : step.positions(walk.leaves().pointBegin[i], walk.leaves().pointCount[i])) {
            const auto place = walk.cell(i).at(point);
            if (fit.takes(place)) fit.add(place);
        }
    }
    if (!fit.inLayer()) fit.add(Bounds{glm::dvec3(-1.0), glm::dvec3(1.0)});
    return fit.camera();
}

TEST(FittedParticles, TheCameraIsThatOfAllPointsThatMayBeSeen) {
    std::mt19937 dice(7);
    for (int round = 0; round < 200; ++round) {
        MemorySource source;
        source.add("test/beam", {clustersOf(dice)});
        const std::string layer = layerOf(dice);
        auto view = test::viewOf("{'width': 160, 'height': 90, 'layers': [" + layer + "]}");
        ASSERT_TRUE(fitLayers(view, source).value());
        EXPECT_EQ(view.camera, cameraByHand(view, source)) << round << ": " << layer;
    }
}

std::string withAxes(const std::string& layer) {
    return "{'width': 160, 'height': 90, 'annotations': {'axes': true}, 'layers': [" + layer + "]}";
}

/// The box that axes stand around, of a view with the camera that it came with or was given.
std::optional<Bounds> boxOf(View view, MemorySource& source) {
    PlotBoxes unknown;
    EXPECT_TRUE(fitLayers(view, source).value());
    EXPECT_TRUE(boxPlots(view, Stage::exact, source, unknown).value());
    return view.shown.at(0);
}

TEST(FittedParticles, AHandThatTakesTheViewChangesNoAxes) {
    std::mt19937 dice(8);
    for (int round = 0; round < 50; ++round) {
        MemorySource source;
        source.add("test/beam", {clustersOf(dice)});
        auto view = test::viewOf(withAxes(layerOf(dice)));
        const auto fitted = boxOf(view, source);
        ASSERT_TRUE(fitted);
        view.cameraFitted = false;
        EXPECT_EQ(boxOf(view, source), fitted) << round;
        PlotBoxes known;
        EXPECT_TRUE(boxPlots(view, Stage::quick, source, known).value());
        View turned = view;
        turned.camera.eye.x += 1.0;
        EXPECT_TRUE(boxPlots(turned, Stage::quick, source, known).value());
        EXPECT_EQ(turned.shown.at(0), fitted);
    }
}

TEST(FittedParticles, AxesAroundThePlotStandStill) {
    std::mt19937 dice(9);
    for (int round = 0; round < 20; ++round) {
        MemorySource source;
        source.add("test/beam", {clustersOf(dice)});
        auto view = test::viewOf(withAxes(layerOf(dice)));
        view.annotations->set_axes_around("plot");
        EXPECT_EQ(boxOf(view, source), std::nullopt) << "the whole plot";
        ASSERT_TRUE(fitLayers(view, source).value());
        const auto& transform = view.layers[0].transform;
        CameraFit plot(outlookOf({}, transform), fittedAspect(view), fitMargin(view).y);
        plot.enter(transform);
        plot.add(plotBounds);
        EXPECT_EQ(view.camera, plot.camera()) << round;
    }
}

TEST(FittedParticles, OnTheWayToAnotherStepAxesGoWithIt) {
    const auto at = [](double place) {
        return test::MemoryStep::make({{glm::dvec3(place), 1.0}, {glm::dvec3(place + 0.1), 1.0}}, {});
    };
    MemorySource source;
    source.add("test/beam", {at(0.1), at(0.7)});
    const auto box = [&](const std::string& rest) {
        return *boxOf(test::viewOf(withAxes("{'dataset': 'test/beam', 'particles': {}" + rest + "}")),
                      source);
    };
    const Bounds first = box(""), last = box(", 'step': 1");
    const Bounds between = box(", 'towards': {'step': 1, 'share': 0.25}");
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(between.min[i], 0.75 * first.min[i] + 0.25 * last.min[i], 1e-12);
        EXPECT_NEAR(between.max[i], 0.75 * first.max[i] + 0.25 * last.max[i], 1e-12);
    }
}

}  // namespace
}  // namespace mote::server
