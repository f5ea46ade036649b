// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's points against closed forms: where they appear, how much of a pixel they cover, what they
// leave.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "protocol/scene/srgb.h"
#include "protocol/scene/write_fields.h"
#include "tests/reference/point_hits.h"
#include "tests/reference/reference_renderer.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

using test::MemoryStep;
using test::viewOf;
using test::WeightedPoint;

constexpr double rounding = 1e-12;  // a few operations on numbers of order one, in double precision

/// Points without any volume.
std::shared_ptr<const MemoryStep> pointsOnly(const std::vector<WeightedPoint>& points) {
    return MemoryStep::make(points, {.volumeLevel = 0, .volume = {0.0F}});
}

/// Layer x and y from -1 to 1 fill a 20 x 20 picture, so that a box position p appears at (20 p.x, 20 - 20
/// p.y).
View squareView(const std::string& points, const std::string& more = "") {
    return viewOf("{'width': 20, 'height': 20," + more +
                  "'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0], 'orthographicHeight': 2},"
                  "'layers': [{'particles': {'volume': {'curve': [{'density': 0, 'opacity': 0}]},"
                  "'points': {" +
                  points + "}}}]}");
}

void expectColor(const glm::dvec3& actual, const glm::dvec3& expected, double tolerance = rounding) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "channel " << i;
}

TEST(ReferencePoints, OnePointFillsItsPixelOnly) {
    const auto step = pointsOnly({{{0.525, 0.325, 0.5}}});  // the middle of pixel (10, 13)
    const auto picture = render({squareView("'opacity': 0.75, 'color': [1, 0, 1]"), {{.step = step}}});
    ASSERT_EQ(picture.linear.size(), 400U);
    for (std::uint32_t row = 0; row < 20; ++row) {
        for (std::uint32_t column = 0; column < 20; ++column) {
            const bool its = column == 10 && row == 13;
            expectColor(picture.at(column, row), its ? glm::dvec3(0.75, 0.0, 0.75) : glm::dvec3(0.0));
        }
    }
}

TEST(ReferencePoints, PerspectiveShrinksWithDepth) {
    // Half the picture's height is 1 at depth 1: from (0, 0, 4) the layer point (1/2, 1/2, 0) has depth 4 and
    // appears at px = 40 (1 + 0.5 / (4 * 2)) = 42.5, py = 20 (1 - 0.5 / 4) = 17.5.
    const auto step = pointsOnly({{{0.75, 0.75, 0.5}}});
    const auto picture =
        render({viewOf("{'width': 80, 'height': 40, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0],"
                       "'fovYDegrees': 90}, 'layers': [{'particles': {'volume': {'curve': ["
                       "{'density': 0, 'opacity': 0}]}, 'points': {'opacity': 0.5, 'color': [1, 1, 1]}}}]}"),
                {{.step = step}}});
    for (std::uint32_t row = 0; row < 40; ++row) {
        for (std::uint32_t column = 0; column < 80; ++column) {
            expectColor(picture.at(column, row), glm::dvec3(column == 42 && row == 17 ? 0.5 : 0.0));
        }
    }
}

TEST(ReferencePoints, ManyPointsLeaveAPower) {
    for (const int count : {1, 2, 7, 60}) {
        const auto step = pointsOnly(std::vector<WeightedPoint>(count, {{0.525, 0.525, 0.4}}));
        const auto picture = render(
            {squareView("'opacity': 0.3, 'color': [1, 0, 0]", "'background': [0, 0, 1],"), {{.step = step}}});
        const double left = std::pow(0.7, count);
        expectColor(picture.at(10, 9), {1.0 - left, 0.0, left});
        expectColor(picture.at(9, 9), {0.0, 0.0, 1.0});
    }
}

TEST(ReferencePoints, BelowOnePixelThePointIsAsOpaqueAsItIsLarge) {
    const auto step = pointsOnly({{{0.525, 0.525, 0.5}}});
    const auto picture =
        render({squareView("'opacity': 0.8, 'sizePixels': 0.5, 'color': [1, 1, 1]"), {{.step = step}}});
    expectColor(picture.at(10, 9), glm::dvec3(0.8 * 0.25));
}

TEST(ReferencePoints, ADiscCoversItsPixelsByDistance) {
    const auto step = pointsOnly({{{0.525, 0.525, 0.5}}});  // pixel (10, 9)
    const auto picture =
        render({squareView("'opacity': 0.8, 'sizePixels': 3, 'color': [1, 1, 1]"), {{.step = step}}});
    // A position is rounded to 1/65536 of the box: a thousandth of a pixel at most, times the coverage's
    // slope of 1.
    constexpr double position = 1e-3;
    expectColor(picture.at(10, 9), glm::dvec3(0.8), position);
    expectColor(picture.at(11, 9), glm::dvec3(0.8), position);
    expectColor(picture.at(11, 10), glm::dvec3(0.8 * (2.0 - std::numbers::sqrt2)), position);
    expectColor(picture.at(10, 11), glm::dvec3(0.0), position);
    expectColor(picture.at(13, 9), glm::dvec3(0.0));
}

TEST(ReferencePoints, ADiscBeyondTheBorderReachesIn) {
    // Its centre is 1.1 pixels left of the picture, at the height of row 9's middle.
    const auto step = pointsOnly({{{0.0, 0.525, 0.5}}});
    auto view = squareView("'opacity': 0.8, 'sizePixels': 4, 'color': [1, 1, 1]");
    view.layers[0].transform[3][0] = -0.11;  // a picture's width is 2
    const auto picture = render({view, {{.step = step}}});
    expectColor(picture.at(0, 9), glm::dvec3(0.8 * (2.5 - 1.6)), 1e-3);
    expectColor(picture.at(1, 9), glm::dvec3(0.0), 1e-3);
    view.layers[0].particles()->mutable_points()->set_size_pixels(1.0);
    expectColor(render({view, {{.step = step}}}).at(0, 9), glm::dvec3(0.0));
}

TEST(ReferencePoints, DiscsHaveTheirAreaOnAverage) {
    // The coverage is a cone's frustum of radii s/2 + 1/2 and s/2 - 1/2 and height 1: pi (s^2/4 + 1/12) in
    // all. Summed over pixels it scatters around that, by less than half a pixel for these sizes; 400 discs
    // at random places halve that twentyfold: five standard errors are an eighth of a pixel.
    std::mt19937_64 random(7);
    const auto share = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    std::vector<WeightedPoint> points;
    for (int i = 0; i < 400; ++i) {
        points.push_back(
            {{(i % 20 + 0.3 + 0.4 * share()) / 20.0, (i / 20 + 0.3 + 0.4 * share()) / 20.0, 0.5}});
    }
    const auto step = pointsOnly(points);
    for (const double size : {1.5, 3.0, 4.5}) {
        auto view = squareView("'opacity': 0.5, 'color': [1, 1, 1]");
        view.width = view.height = 240;  // 12 pixels a disc: they do not touch
        view.layers[0].particles()->mutable_points()->set_size_pixels(size);
        double sum = 0.0;
        for (const auto& color : render({view, {{.step = step}}}).linear) sum += color.x;
        EXPECT_NEAR(sum / (0.5 * 400.0), std::numbers::pi * (0.25 * size * size + 1.0 / 12.0), 0.125) << size;
    }
}

TEST(ReferencePoints, NothingIsSeenTooNearToAPerspectiveEye) {
    // The eye at z = 1 and the target 1000 away: the nearest depth is 1, at z = 0.
    const auto view = [](const char* more) {
        return viewOf(
            std::string("{'width': 3, 'height': 3, 'camera': {'eye': [0, 0, 1], 'target': [0, 0, -999]") +
            more +
            "}, 'layers': [{'particles': {'volume': {'curve': [{'density': 0, 'opacity': 0}]},"
            "'points': {'opacity': 1, 'color': [1, 1, 1]}}}]}");
    };
    const auto tooNear = pointsOnly({{{0.5, 0.5, 0.51}}});
    const auto seen = pointsOnly({{{0.5, 0.5, 0.49}}});
    expectColor(render({view(""), {{.step = tooNear}}}).at(1, 1), glm::dvec3(0.0));
    expectColor(render({view(""), {{.step = seen}}}).at(1, 1), glm::dvec3(ParticlesStyle::opacityLimit));
    // An orthographic eye sees what lies behind it too.
    auto behind = view(", 'orthographicHeight': 2");
    behind.camera.eye.z = -0.5;
    expectColor(render({behind, {{.step = tooNear}}}).at(1, 1), glm::dvec3(ParticlesStyle::opacityLimit));
}

TEST(ReferencePoints, TheFractionIsTakenFromTheHeadOfEachLeaf) {
    // Two cells of the first level: 64 points in one, a single one in the other. Density rises with the
    // count.
    std::vector<WeightedPoint> points(64, {{0.275, 0.275, 0.3}});
    points.push_back({{0.775, 0.775, 0.8}});
    const auto step =
        MemoryStep::make(points, {.leafCapacity = 64, .maxLevel = 1, .volumeLevel = 0, .volume = {0.0F}});
    ASSERT_EQ(step->leaves().size(), 2U);
    const auto view = [&](const char* curve) {
        return squareView(std::string("'linked': false, 'opacity': 0.01, 'color': [1, 1, 1], 'curve': ") +
                          curve);
    };
    const auto thin =
        render({view("[{'density': 0, 'fraction': 1}, {'density': 1, 'fraction': 0}]"), {{.step = step}}});
    expectColor(thin.at(15, 4), glm::dvec3(0.01));
    expectColor(thin.at(5, 14), glm::dvec3(0.0));
    const auto quarter = render({view("[{'density': 1, 'fraction': 0.25}]"), {{.step = step}}});
    // floor(16 + u) with u in [0, 1) is 16.
    expectColor(quarter.at(5, 14), glm::dvec3(1.0 - std::pow(0.99, 16)));
}

TEST(ReferencePoints, LayersShareOneDepth) {
    const auto step = pointsOnly({{{0.525, 0.525, 0.5}}});
    auto view = squareView("'opacity': 0.5, 'color': [1, 0, 0]");
    view.layers.push_back(view.layers.front());
    writeColor({0.0, 1.0, 0.0}, view.layers[1].particles()->mutable_points()->mutable_color());
    for (const double nearer : {-0.5, 0.5}) {
        view.layers[1].transform[3][2] = nearer;  // towards the eye
        const auto color = render({view, {{.step = step}, {.step = step}}}).at(10, 9);
        expectColor(color, nearer > 0.0 ? glm::dvec3(0.25, 0.5, 0.0) : glm::dvec3(0.5, 0.25, 0.0));
    }
}

TEST(ReferencePoints, DoubtfulPixelsAreMarked) {
    // On the border of columns 9 and 10, and away from any.
    const auto onBorder = pointsOnly({{{0.5, 0.525, 0.5}}});
    auto view = squareView("'opacity': 0.5, 'color': [1, 0, 0]");
    const auto picture = render({view, {{.step = onBorder}}});
    for (std::uint32_t i = 0; i < 400; ++i) {
        EXPECT_EQ(picture.ambiguous[i], i == 9 * 20 + 9 || i == 9 * 20 + 10 ? 1 : 0) << i;
    }
    view.layers[0].particles()->mutable_points()->set_size_pixels(
        2.0);  // a disc is continuous in its place: never in doubt
    const auto disc = render({view, {{.step = onBorder}}});
    EXPECT_EQ(std::count(disc.ambiguous.begin(), disc.ambiguous.end(), 1), 0);
}

TEST(ReferenceEncoding, FollowsSrgb) {
    Picture picture{
        5,
        1,
        {glm::dvec3(0.0), glm::dvec3(1.0), glm::dvec3(0.5), glm::dvec3(0.001), glm::dvec3(2.0, -1.0, 1.0)},
        {}};
    const auto image = encode(picture);
    // IEC 61966-2-1: 0.5 encodes to 0.7354 = 187.5 / 255, 0.001 to 12.92 / 1000 = 3.29 / 255.
    const std::vector<std::uint8_t> expected{0,   0,   0, 255, 255, 255, 255, 255, 188, 188,
                                             188, 255, 3, 3,   3,   255, 255, 0,   255, 255};
    EXPECT_EQ(image.pixels, expected);
}

TEST(ReferencePicture, WithoutLayersIsItsBackground) {
    const auto view = viewOf("{'width': 3, 'height': 2, 'background': [1, 0.5, 0]}");
    const auto picture = render({view, {}});
    ASSERT_EQ(picture.linear.size(), 6U);
    for (const auto& color : picture.linear) expectColor(color, {1.0, srgbToLinear(0.5), 0.0});
}

}  // namespace
}  // namespace mote::reference
