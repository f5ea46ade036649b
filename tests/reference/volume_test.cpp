// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's volume against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "server/render/plan/step_volume.h"
#include "tests/reference/reference_renderer.h"
#include "tests/reference/volume_field.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

using test::MemoryStep;
using test::viewOf;

constexpr double volumeRounding = 1e-10;  // a thousand steps, each rounded to 1e-16 of its size, with room
constexpr LogDensity scale{1.0, 100.0};

/// A volume without points, all of one scaled log density or one a cell (x fastest).
std::shared_ptr<const MemoryStep> volumeOf(std::uint8_t level, const std::vector<double>& t) {
    std::vector<float> densities;
    for (const double value : t) densities.push_back(static_cast<float>(std::pow(100.0, value)));
    return MemoryStep::make({}, {.volumeLevel = level, .logDensity = scale, .volume = densities});
}

std::shared_ptr<const MemoryStep> evenVolume(double t) {
    return volumeOf(3, std::vector<double>(512, t));
}

/// `camera`, `opacity` curve and points as JSON.
View view(const std::string& camera, const std::string& curve, const std::string& background = "[0, 0, 0]",
          const std::string& points = "{}") {
    return viewOf("{'width': 21, 'height': 11, 'background': " + background + ", 'camera': {" + camera +
                  "}, 'layers': [{'particles': {'volume': {'colorMap': 'viridis', 'curve': " + curve +
                  "}, 'points': " + points + "}}]}");
}

const char* const perspective = "'eye': [0, 0, 4], 'target': [0, 0, 0], 'fovYDegrees': 10";
const char* const orthographic = "'eye': [0, 0, 4], 'target': [0, 0, 0], 'orthographicHeight': 0.8";
const char* const onePercent = "[{'density': 0, 'opacity': 0.01}]";

void expectVolumeColor(const glm::dvec3& actual, const glm::dvec3& expected,
                       double tolerance = volumeRounding) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "channel " << i;
}

TEST(ReferenceVolume, EvenDensityDimsByBeerAndLambert) {
    const auto step = evenVolume(0.7);
    const glm::dvec3 own = ColorMap::find("viridis").value()(0.7);
    for (const char* camera : {perspective, orthographic}) {
        const auto scene = view(camera, onePercent, "[1, 1, 1]");
        const auto picture = render({scene, {{.step = step}}});
        for (std::uint32_t row = 0; row < 11; ++row) {
            for (std::uint32_t column = 0; column < 21; ++column) {
                // Every ray enters at z = 1 and leaves at z = -1.
                const double half = std::tan(5.0 * std::numbers::pi / 180.0);
                const double x = (2.0 * (column + 0.5) / 21.0 - 1.0) * half * 21.0 / 11.0;
                const double y = (1.0 - 2.0 * (row + 0.5) / 11.0) * half;
                const double length = scene.camera.perspective() ? 2.0 * std::sqrt(1.0 + x * x + y * y) : 2.0;
                const double left = std::pow(0.99, 32.0 * length);
                // Densities are floats: 0.7 is met to 1e-8.
                expectVolumeColor(picture.at(column, row), (1.0 - left) * own + left, 1e-7);
            }
        }
    }
}

TEST(ReferenceVolume, LengthIsMeasuredInLayerSpace) {
    // Stretched along the ray or shrunk as a whole: the middle ray always crosses two units of layer space.
    const auto step = evenVolume(1.0);
    const glm::dvec3 own = ColorMap::find("viridis").value()(1.0);
    const double left = std::pow(0.99, 64.0);
    for (const glm::dvec3& size : {glm::dvec3(1.0, 1.0, 3.0), glm::dvec3(0.2), glm::dvec3(7.0, 2.0, 0.1)}) {
        auto scene = view(orthographic, onePercent);
        scene.layers[0].transform = glm::scale(glm::dmat4(1.0), size);
        expectVolumeColor(render({scene, {{.step = step}}}).at(10, 5), (1.0 - left) * own, 1e-7);
    }
}

TEST(ReferenceVolume, ARaySeesOnlyWhatIsInFrontOfTheEye) {
    const auto step = evenVolume(1.0);
    const glm::dvec3 own = ColorMap::find("viridis").value()(1.0);
    // The nearest depth is a thousandth of the distance to the target, 0.02.
    const auto inside = view("'eye': [0, 0, 0], 'target': [0, 0, -20]", onePercent);
    expectVolumeColor(render({inside, {{.step = step}}}).at(10, 5), (1.0 - std::pow(0.99, 32.0 * 0.98)) * own,
                      1e-7);
    const auto away = view("'eye': [0, 0, 4], 'target': [0, 0, 5]", onePercent);
    expectVolumeColor(render({away, {{.step = step}}}).at(10, 5), glm::dvec3(0.0));
    // Orthographic: also what is behind.
    const auto parallel =
        view("'eye': [0, 0, 0], 'target': [0, 0, -20], 'orthographicHeight': 0.8", onePercent);
    expectVolumeColor(render({parallel, {{.step = step}}}).at(10, 5), (1.0 - std::pow(0.99, 64.0)) * own,
                      1e-7);
}

TEST(ReferenceVolume, CellsAreInterpolatedBetweenTheirCentres) {
    // Two cells a side: t is 0.2 up to x = -1/2, 0.8 from x = 1/2 on, linear between, the same along y and z.
    const auto step = volumeOf(1, {0.2, 0.8, 0.2, 0.8, 0.2, 0.8, 0.2, 0.8});
    const auto style = particlesStyleOf(*view(orthographic, onePercent).layers[0].particles());
    const VolumeField field(*step, style);
    for (const double x : {-1.0, -0.7, -0.5, -0.2, 0.0, 0.31, 0.5, 0.99}) {
        const double expected = 0.2 + 0.6 * std::clamp(x + 0.5, 0.0, 1.0);
        EXPECT_NEAR(field.t({x, 0.4, -0.9}), expected, 1e-7);
        EXPECT_NEAR(field.t({x, -1.0, 1.0}), expected, 1e-7);
    }
}

TEST(ReferenceVolume, AxesAreNotExchanged) {
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> t(8);
        for (int i = 0; i < 8; ++i) t[i] = i >> axis & 1 ? 0.9 : 0.1;
        const VolumeField field(*volumeOf(1, t),
                                particlesStyleOf(*view(orthographic, onePercent).layers[0].particles()));
        glm::dvec3 place(-0.8);
        EXPECT_NEAR(field.t(place), 0.1, 1e-7);
        place[axis] = 0.8;
        EXPECT_NEAR(field.t(place), 0.9, 1e-7);
    }
}

TEST(ReferenceVolume, ARampAlongTheRayIsIntegrated) {
    // Two slices: extinction rises from 0 at z = -1/2 to that of an opacity of 1/20 at z = 1/2, constant
    // beyond: over all of the way that is as much as a length of 1 of it. The midpoint rule errs by h^2/24
    // times the jump of the slope (32/20) at the two kinks: for 64 samples in a cell of length 1 about 2e-5.
    // The densities are nearly alike and there are no points beside it, so that all of it is a volume.
    const auto step = volumeOf(1, {0.9, 0.9, 0.9, 0.9, 1, 1, 1, 1});
    auto scene = view(orthographic, "[{'density': 0.9, 'opacity': 0}, {'density': 1, 'opacity': 0.05}]",
                      "[0, 0, 0]", "{'linked': false, 'curve': [{'density': 0, 'fraction': 0}]}");
    const auto transmittance = [&](double samples) {
        scene.background = glm::dvec3(1.0);
        const auto lit = render({scene, {{.step = step}}}, {samples}).at(10, 5).x;
        scene.background = glm::dvec3(0.0);
        return lit - render({scene, {{.step = step}}}, {samples}).at(10, 5).x;
    };
    const double depth = -32.0 * std::log(0.95);
    EXPECT_NEAR(-std::log(transmittance(64.0)), depth, 1e-4);
    EXPECT_NEAR(-std::log(transmittance(1024.0)), depth, 4e-7);
}

TEST(ReferenceVolume, DevicesHoldTheSameCells) {
    int shown = 0;
    for (std::uint8_t level = 0; level < 7; ++level) {
        const auto step =
            MemoryStep::make(test::beam({.core = 6000, .halo = 1500, .filaments = 500, .seed = level}),
                             {.leafCapacity = 16, .maxLevel = 10, .volumeLevel = level});
        const auto seen =
            view(orthographic, "[{'density': 0.5, 'opacity': 0}, {'density': 0.6, 'opacity': 0.9}]");
        const auto style = particlesStyleOf(*seen.layers[0].particles());
        const VolumeField field(*step, style);
        const auto cells = render::stepVolume(*step, style.transfer(), style.pointFraction);
        double most = 0.0;
        for (const float root : cells.root) most = std::max(most, static_cast<double>(root));
        shown += most > 0.0 ? 1 : 0;
        const double edge = std::ldexp(2.0, -static_cast<int>(cells.level));
        for (std::uint32_t z = 0; z < cells.size.z; ++z) {
            for (std::uint32_t y = 0; y < cells.size.y; ++y) {
                for (std::uint32_t x = 0; x < cells.size.x; ++x) {
                    const glm::dvec3 place =
                        edge * (glm::dvec3(cells.first + glm::uvec3(x, y, z)) + 0.5) - 1.0;
                    EXPECT_NEAR(cells.root[cells.index(x, y, z)], std::cbrt(field.extinction(place)),
                                1e-5 * most)
                        << int{level} << " " << x << " " << y << " " << z;
                }
            }
        }
    }
    EXPECT_GE(shown, 4);
}

TEST(ReferenceVolume, EmptyCellsAreClear) {
    const auto step =
        MemoryStep::make({}, {.volumeLevel = 1, .logDensity = scale, .volume = std::vector<float>(8, 0.0F)});
    const auto scene = view(perspective, "[{'density': 0, 'opacity': 1}]", "[1, 1, 1]");
    for (const auto& color : render({scene, {{.step = step}}}).linear)
        expectVolumeColor(color, glm::dvec3(1.0));
}

TEST(ReferenceVolume, WhatIsThinnerThanTheScaleIsAsAtItsEnd) {
    const auto step = evenVolume(-0.0625);
    const auto scene = view(orthographic, onePercent, "[1, 1, 1]");
    const double left = std::pow(0.99, 64.0);
    const glm::dvec3 own = ColorMap::find("viridis").value()(0.0);
    expectVolumeColor(render({scene, {{.step = step}}}).at(10, 5), (1.0 - left) * own + left, 1e-7);
}

}  // namespace
}  // namespace mote::reference
