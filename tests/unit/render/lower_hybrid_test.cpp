// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/lower_hybrid.h"

#include <gtest/gtest.h>

#include <array>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "server/render/layers/make_frame_plan.h"
#include "server/render/plan/seen_fields.h"
#include "tests/support/hybrid_scene.h"

namespace mote::render {
namespace {

using enum HybridRepresentation;

std::shared_ptr<const GridField> machine(HybridRepresentation parts) {
    return test::hybridOf({.threshold = 0.1, .parts = parts}, test::machineParts);
}

CorrectedField fieldOf(const std::shared_ptr<const GridField>& grid, HybridRepresentation representation,
                       double opacity = 1.0, const char* shape = "square") {
    constexpr std::array words{"", "points", "residual", "volume"};
    auto style = *parseHybridStyle({});
    style.set_representation(words.at(static_cast<std::size_t>(representation)));
    style.set_point_opacity(opacity);
    style.set_point_shape(shape);
    View view{.width = 8, .height = 8, .camera = fitCamera(grid->bounds(), 1.0), .layers = {}};
    view.layers.push_back({.dataset = "data/a", .style = style});
    const Scene scene{view, {{.hybrid = grid}}};
    return *makeFramePlan(scene, Quality::exact()).fields.at(0).grid();
}

TEST(LowerHybrid, PointsCorrectAsMuchAsTheirStyleSays) {
    const auto grid = machine(points);
    EXPECT_TRUE(fieldOf(grid, best, 0.3).mixed()) << "its points";
    for (const double opacity : {0.0, 0.3, 1.0}) {
        const auto field = fieldOf(grid, points, opacity);
        EXPECT_EQ(field.corrected(), opacity > 0.0);
        EXPECT_EQ(field.mixed(), opacity == 0.3);
        EXPECT_EQ(field.correction, opacity);
    }
    EXPECT_FALSE(fieldOf(grid, volume).corrected());
    EXPECT_FALSE(fieldOf(machine(volume), points).corrected()) << "they may be on their way";
}

TEST(LowerHybrid, AResidualKnowsNothingOfPoints) {
    const auto field = fieldOf(machine(residual), residual, 0.3);
    EXPECT_TRUE(field.corrected());
    EXPECT_FALSE(field.mixed());
    EXPECT_EQ(field.steepness, 1.0);
}

TEST(LowerHybrid, ShapesAreAsSteepAsPictureSays) {
    const auto grid = machine(points);
    EXPECT_EQ(fieldOf(grid, points, 1.0, "gaussian").steepness, 1.0);
    EXPECT_EQ(fieldOf(grid, points, 1.0, "disc").steepness, 2.0);
    EXPECT_EQ(fieldOf(grid, points, 1.0, "square").steepness, 8.0);
}

TEST(LowerHybrid, ACurveWithoutColoursCanBeRead) {
    const auto grid = machine(volume);
    const auto colorAt = [&](double value, proto::HybridStyle style) {
        for (const double knot : {0.25, 0.75}) {
            auto& at = *style.add_curve();
            at.set_value(grid->range.low + knot * (grid->range.high - grid->range.low));
            at.set_opacity(knot);
        }
        const double share = grid->range.low + value * (grid->range.high - grid->range.low);
        return transferOf(hybridStyleOf(*parseHybridStyle(style)), *grid).color(share);
    };
    const auto viridis = ColorMap::find("viridis").value();
    const auto expectColor = [](const glm::dvec3& got, const glm::dvec3& wanted) {
        EXPECT_TRUE(glm::all(glm::lessThan(glm::abs(got - wanted), glm::dvec3(1e-6))));
    };
    expectColor(colorAt(0.25, {}), viridis(0.4));
    expectColor(colorAt(0.5, {}), viridis(0.7));
    expectColor(colorAt(0.75, {}), viridis(1.0));
    proto::HybridStyle named;
    named.set_color_map("viridis");
    expectColor(colorAt(0.25, named), viridis(0.0));
    expectColor(colorAt(0.5, named), viridis(0.5));
    proto::HybridStyle ranged;
    for (const double end : {grid->range.low, grid->range.high}) ranged.add_color_range(end);
    expectColor(colorAt(0.5, ranged), viridis(0.5));
}

TEST(LowerHybrid, GreatestValuesHaveColoursUpToTheHighest) {
    GridField field = *machine(volume);
    field.range = {0.0, 256.0};
    field.histogram.assign(256, 0.0);
    for (std::size_t bin = 0; bin < 200; ++bin) field.histogram[bin] = bin < 100 ? 1000.0 : 10.0;
    field.histogram[255] = 1.0;  // one that stands out
    proto::HybridStyle style;
    for (const double knot : {50.0, 100.0}) style.add_curve()->set_value(knot);
    const auto viridis = ColorMap::find("viridis").value();
    const auto colorAt = [&](double value) {
        return transferOf(hybridStyleOf(*parseHybridStyle(style)), field).color(value);
    };
    EXPECT_LT(glm::distance(colorAt(100.0), viridis(1.0)), 1e-6);
    style.set_shows("maximum");
    EXPECT_LT(glm::distance(colorAt(50.0), viridis(0.4)), 1e-6);
    EXPECT_LT(glm::distance(colorAt(125.0), viridis(0.7)), 0.01);
    EXPECT_LT(glm::distance(colorAt(200.0), viridis(1.0)), 1e-6);
    style.set_color_map("viridis");
    EXPECT_LT(glm::distance(colorAt(125.0), viridis(0.5)), 0.01);
}

TEST(LowerHybrid, TheUnitOfValuesDecidesTheDefaultCurve) {
    GridField field = *machine(volume);
    field.range = {0.0, 255.0};
    EXPECT_LT(defaultOpacity(field).knots().front().x, 255.0);
    field.unit = "HU";
    EXPECT_EQ(defaultOpacity(field).knots().front().x, 290.0);
}

TEST(LowerHybrid, ALayerThatFadesIsThinned) {
    const auto grid = machine(residual);
    View view{.width = 8, .height = 8, .camera = fitCamera(grid->bounds(), 1.0), .layers = {}};
    view.layers.push_back({.dataset = "data/a", .style = *parseHybridStyle({})});
    Scene scene{view, {{.hybrid = grid}}};
    const auto whole = makeFramePlan(scene, Quality::exact()).fields.at(0).transfer;
    scene.view.layers[0].opacity = 0.25;
    const auto thin = makeFramePlan(scene, Quality::exact()).fields.at(0).transfer;
    EXPECT_EQ(thin.opacity, whole.opacity);
    EXPECT_GT(whole.extinction(grid->range.high), 0.0);
    EXPECT_DOUBLE_EQ(thin.extinction(grid->range.high), 0.25 * whole.extinction(grid->range.high));
}

TEST(GridRanges, HoldWhatShowsOfTheCoarseGridInBricks) {
    const auto step = machine(points);
    const auto whole = gridRanges({.grid = step}).ranges(),
               low = gridRanges({.grid = step, .bricks = false}).ranges();
    const auto mixed = gridRanges({.grid = step, .correction = 0.5}).ranges();
    const auto& count = step->bricks->count;
    ASSERT_EQ(low.size(), 1U);  // 8 x 8 x 8 samples
    bool wider = false;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        EXPECT_LE(mixed[i].low, whole[i].low);
        EXPECT_GE(mixed[i].high, whole[i].high);
        EXPECT_TRUE(mixed[i].low == whole[i].low || mixed[i].low >= low[0].low);
        EXPECT_TRUE(mixed[i].high == whole[i].high || mixed[i].high <= low[0].high);
        wider = wider || mixed[i].low < whole[i].low || mixed[i].high > whole[i].high;
        const glm::uvec3 brick(i % count.x, i / count.x % count.y, i / count.x / count.y);
        for (std::uint32_t corner = 0; corner < 8; ++corner) {
            // The coarse grid at the brick's corners lies within.
            const glm::uvec3 at = (brick + glm::uvec3(corner & 1U, corner >> 1 & 1U, corner >> 2)) * 2U;
            const auto value = static_cast<float>(
                step->valueOf(step->coarse.values[step->coarse.index(glm::min(at, step->coarse.size - 1U))]));
            if (glm::all(glm::lessThan(at, step->coarse.size))) {
                EXPECT_LE(mixed[i].low, value) << i;
                EXPECT_GE(mixed[i].high, value) << i;
            }
        }
    }
    EXPECT_TRUE(wider);
}

}  // namespace
}  // namespace mote::render
