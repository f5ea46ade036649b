// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's points and volumes in one ray, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/reference/reference_renderer.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

using test::MemoryStep;
using test::viewOf;
using test::WeightedPoint;

// Optical depths of order one over a thousand steps, and densities that are floats.
constexpr double tolerance = 1e-6;

std::shared_ptr<const MemoryStep> evenVolumeWith(const std::vector<WeightedPoint>& points) {
    return MemoryStep::make(
        points,
        {.volumeLevel = 2, .logDensity = LogDensity{1.0, 100.0}, .volume = std::vector<float>(64, 100.0F)});
}

View view() {
    return viewOf(
        "{'width': 3, 'height': 3, 'background': [0, 0, 1],"
        "'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0], 'orthographicHeight': 1},"
        "'layers': [{'particles': {'volume': {'curve': [{'density': 0, 'opacity': 0.02}]},"
        "'points': {'linked': false, 'curve': [{'density': 0, 'fraction': 1}], 'opacity': 0.6, 'color': [0, "
        "1, 0]}"
        "}}]}");
}

const glm::dvec3 point{0.0, 1.0, 0.0};
const glm::dvec3 background{0.0, 0.0, 1.0};

glm::dvec3 volumeColor() {
    return ColorMap::standard()(1.0);
}

/// Light through `length` of the volume, in front of `behind`.
glm::dvec3 through(double length, const glm::dvec3& behind) {
    const double left = std::pow(0.98, 32.0 * length);
    return (1.0 - left) * volumeColor() + left * behind;
}

glm::dvec3 pointOver(const glm::dvec3& behind) {
    return 0.6 * point + 0.4 * behind;
}

void expectMixed(const glm::dvec3& actual, const glm::dvec3& expected) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "channel " << i;
}

/// A position keeps 16 bits of its leaf, a fourth of the box, rounded to the middle of its step.
double layerZ(double inBox) {
    return 2.0 * (std::floor(inBox * 262144.0) + 0.5) / 262144.0 - 1.0;
}

TEST(ReferenceMixing, APointInsideTheVolumeIsDimmedByWhatIsInFront) {
    for (const double z : {0.001, 0.25, 0.5, 0.9}) {
        const auto step = evenVolumeWith({{{0.5, 0.5, z}}});
        const double front = 1.0 - layerZ(z);
        expectMixed(render({view(), {{.step = step}}}).at(1, 1),
                    through(front, pointOver(through(2.0 - front, background))));
        expectMixed(render({view(), {{.step = step}}}).at(0, 0), through(2.0, background));
    }
}

TEST(ReferenceMixing, SeveralPointsCutTheVolume) {
    const auto step =
        evenVolumeWith({{{0.5, 0.5, 0.2}}, {{0.5, 0.5, 0.8}}, {{0.5, 0.5, 0.5}}, {{0.5, 0.5, 0.5}}});
    const double first = 1.0 - layerZ(0.8), second = 1.0 - layerZ(0.5), third = 1.0 - layerZ(0.2);
    const glm::dvec3 behindSecond = through(third - second, pointOver(through(2.0 - third, background)));
    expectMixed(render({view(), {{.step = step}}}).at(1, 1),
                through(first, pointOver(through(second - first, pointOver(pointOver(behindSecond))))));
}

TEST(ReferenceMixing, APointOfAnotherLayerInFrontAndBehind) {
    const auto volume = evenVolumeWith({});
    const auto onePoint = MemoryStep::make({{{0.5, 0.5, 0.5}}}, {.volumeLevel = 0, .volume = {0.0F}});
    auto scene = view();
    scene.layers.push_back(scene.layers.front());
    scene.layers[1].particles()->mutable_volume()->mutable_curve(0)->set_opacity(0.0);
    scene.layers[1].transform[3][2] = 2.0;
    expectMixed(render({scene, {{.step = volume}, {.step = onePoint}}}).at(1, 1),
                pointOver(through(2.0, background)));
    scene.layers[1].transform[3][2] = -2.0;
    expectMixed(render({scene, {{.step = volume}, {.step = onePoint}}}).at(1, 1),
                through(2.0, pointOver(background)));
}

TEST(ReferenceMixing, OverlappingVolumesAddTheirExtinctionsAndEmissions) {
    const auto step = evenVolumeWith({});
    auto scene = view();
    scene.layers.push_back(scene.layers.front());
    scene.layers[1].particles()->mutable_volume()->mutable_curve(0)->set_opacity(0.05);
    scene.layers[1].particles()->mutable_volume()->set_color_map("oslo");
    scene.layers[1].transform[3][2] =
        0.5;  // half a unit nearer: 0.5 alone, 1.5 together, 0.5 of the first alone
    const double one = -32.0 * std::log(0.98), other = -32.0 * std::log(0.95);
    const glm::dvec3 a = volumeColor(), b = ColorMap::find("oslo").value()(1.0);
    const auto over = [](double depth, const glm::dvec3& color, const glm::dvec3& behind) {
        return (1.0 - std::exp(-depth)) * color + std::exp(-depth) * behind;
    };
    const glm::dvec3 expected = over(
        0.5 * other, b,
        over(1.5 * (one + other), (one * a + other * b) / (one + other), over(0.5 * one, a, background)));
    expectMixed(render({scene, {{.step = step}, {.step = step}}}).at(1, 1), expected);
    // The order of the layers says nothing.
    std::swap(scene.layers[0], scene.layers[1]);
    expectMixed(render({scene, {{.step = step}, {.step = step}}}).at(1, 1), expected);
}

TEST(ReferenceMixing, AnOpaquePointHidesAllButALimit) {
    auto scene = view();
    scene.layers[0].particles()->mutable_points()->set_opacity(ParticlesStyle::opacityLimit);
    const auto step = evenVolumeWith({{{0.5, 0.5, 0.75}}});
    const double front = 1.0 - layerZ(0.75);
    const double limit = ParticlesStyle::opacityLimit;
    expectMixed(render({scene, {{.step = step}}}).at(1, 1),
                through(front, limit * point + (1.0 - limit) * through(2.0 - front, background)));
}

}  // namespace
}  // namespace mote::reference
