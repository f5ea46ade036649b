// SPDX-License-Identifier: GPL-3.0-or-later
//
// What layers of particles show of their numbers, held to what must be true of any of them: pictures of the
// cpu device with and without.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "protocol/scene/srgb.h"
#include "server/render/layers/particles/point_data.h"
#include "storage/numbers/point_places.h"
#include "tests/views/difference_check.h"
#include "tests/views/number_data.h"
#include "tests/views/particle_data.h"
#include "tests/views/view_data.h"
#include "tests/views/view_drawer.h"

namespace mote::test {
namespace {

proto::View viewOf(const std::string& dataset) {
    proto::View view;
    view.set_width(61);
    view.set_height(47);
    auto& layer = *view.add_layers();
    layer.set_dataset(dataset);
    layer.mutable_particles()->mutable_volume()->add_curve()->set_opacity(0.0);
    layer.mutable_particles()->mutable_points()->set_linked(false);
    auto& points = *layer.mutable_particles()->mutable_points();
    for (const double density : {0.0, 1.0}) {
        auto& knot = *points.add_curve();
        knot.set_density(density);
        knot.set_fraction(1.0);
    }
    points.set_opacity(0.3);
    // A selection's densities are not those of all.
    for (const double component : {0.8, 0.6, 0.2}) points.add_color(component);
    auto& camera = *view.mutable_camera();
    for (const double x : {2.0, 1.5, 3.0}) camera.add_eye(x);
    for (const double x : {0.0, 0.0, 0.0}) camera.add_target(x);
    for (const double x : {0.0, 1.0, 0.0}) camera.add_up(x);
    return view;
}

class Numbers : public testing::Test {
  protected:
    render::Picture draw(const proto::View& view) {
        const auto scene = data_.scene(view);
        EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().toString());
        return drawer_->draw(*scene, render::Quality::exact());
    }
    /// Greatest difference in steps of 255.
    int worst(const proto::View& one, const proto::View& other) {
        const auto a = draw(one), b = draw(other);
        int most = 0;
        for (std::size_t i = 0; i < a.pixels.size(); ++i)
            most = std::max(most, std::abs(int{a.pixels[i]} - int{b.pixels[i]}));
        return most;
    }

    ViewData data_;
    std::unique_ptr<ViewDrawer> drawer_ = drawerOf("cpu");
};

constexpr std::array<const char*, 8> datasets{"views/empty-0",  "views/one-1",  "views/few-2",
                                              "views/border-3", "views/lump-4", "views/cloud-5",
                                              "views/beam-6",   "views/wide-7"};

TEST_F(Numbers, OfASelectionOfEverythingThePictureIsTheOneWithout) {
    for (const char* dataset : datasets) {
        const auto plain = viewOf(dataset);
        auto all = plain, range = plain;
        all.mutable_layers(0)->mutable_select();
        auto& wide = *range.mutable_layers(0)->mutable_select()->add_ranges();
        wide.set_column("x");
        wide.set_min(-1.0);
        EXPECT_EQ(worst(plain, all), 0) << dataset;
        EXPECT_EQ(worst(plain, range), 0) << dataset;
    }
}

TEST_F(Numbers, ASelectionAndItsNegationShowAllPoints) {
    for (const char* dataset : datasets) {
        const auto whole = viewOf(dataset);
        auto parts = whole;
        *parts.add_layers() = parts.layers(0);
        proto::Selection some;
        auto& range = *some.add_ranges();
        range.set_column("x");
        range.set_max(0.45);
        *parts.mutable_layers(0)->mutable_select() = some;
        *parts.mutable_layers(1)->mutable_select()->mutable_negated() = some;
        EXPECT_EQ(draw(whole).pointsDrawn, draw(parts).pointsDrawn) << dataset;
        EXPECT_LE(worst(whole, parts), 1) << dataset;
    }
}

TEST_F(Numbers, OfAConstantColumnTheColorIsFlat) {
    for (const char* dataset : datasets) {
        for (const char* ofPixel : {"mean", "nearest"}) {
            auto flat = viewOf(dataset), colored = flat;
            auto& colorBy = *colored.mutable_layers(0)->mutable_color_by();
            colorBy.set_column("constant");
            colorBy.set_of_pixel(ofPixel);
            const auto middle = (*ColorMap::find("viridis"))(0.5);
            auto& color = *flat.mutable_layers(0)->mutable_particles()->mutable_points()->mutable_color();
            for (int i = 0; i < 3; ++i) color[i] = linearToSrgb(middle[i]);
            EXPECT_LE(worst(flat, colored), 1) << dataset << ' ' << ofPixel;
        }
    }
}

TEST_F(Numbers, OfNothingHighlightedThePictureIsTheOneWithout) {
    for (const char* dataset : datasets) {
        const auto plain = viewOf(dataset);
        auto none = plain;
        none.mutable_layers(0)->mutable_highlight()->mutable_selection()->mutable_negated();
        EXPECT_EQ(worst(plain, none), 0) << dataset;
    }
}

TEST_F(Numbers, HighlightedPointsShowInTheirColorThroughTheDensest) {
    auto view = viewOf("views/beam-6");
    view.mutable_layers(0)->mutable_particles()->mutable_points()->set_opacity(1.0);
    auto& highlight = *view.mutable_layers(0)->mutable_highlight();
    auto& all = *highlight.mutable_selection()->add_ranges();
    all.set_column("x");
    all.set_min(-1.0);
    highlight.set_size_pixels(5.0);
    for (const double c : {0.0, 1.0, 0.0}) highlight.add_color(c);
    const auto picture = draw(view);
    for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
        EXPECT_LE(picture.pixels[i], 4);
        EXPECT_LE(picture.pixels[i + 2], 4);
    }
}

TEST(PointCodes, HoldAnyNumber) {
    using render::codeOf;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const ValueRange range{-1.0, 3.0}, one{2.0, 2.0};
    EXPECT_EQ(codeOf(std::nan(""), range), render::noValue);
    EXPECT_EQ(codeOf(-infinity, range), 0);
    EXPECT_EQ(codeOf(-1.0, range), 0);
    EXPECT_EQ(codeOf(1.0, range), render::greatestValue / 2);
    EXPECT_EQ(codeOf(3.0, range), render::greatestValue);
    EXPECT_EQ(codeOf(infinity, range), render::greatestValue);
    EXPECT_EQ(codeOf(2.0, one), render::greatestValue / 2);
    EXPECT_EQ(codeOf(1.0, one), 0);
    EXPECT_EQ(codeOf(2.5, one), render::greatestValue);
}

TEST(PointPaths, GoThroughThePlacesOfTheirIds) {
    std::vector<MemoryRun::Step> steps;
    for (std::uint32_t step = 0; step < 3; ++step) steps.push_back(withNumbers(particleStep("few", 3, step)));
    const MemoryRun run(std::move(steps), {});
    const std::vector<std::uint64_t> ids{0, 1, 5, 1000000};
    const auto paths = render::pointPaths(run, ids, {});
    ASSERT_TRUE(paths.ok());
    ASSERT_EQ((*paths)->size(), ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) {
        std::vector<glm::dvec3> expected;
        for (std::uint32_t index = 0; index < 3; ++index) {
            const auto& [points, columns] = run.at(index);
            const storage::LeafWalk walk(*points);
            for (std::uint64_t point = 0; point < points->pointCount(); ++point) {
                if (columns->ids(point, 1).front() != ids[i]) continue;
                expected.push_back(walk.cell(walk.leafOf(point)).at(points->positions(point, 1).front()));
                break;
            }
        }
        const auto& all = (*paths)->places;
        const std::vector<glm::dvec3> way(all.begin() + (*paths)->begin[i],
                                          all.begin() + (*paths)->begin[i + 1]);
        EXPECT_EQ(way, expected) << ids[i];
    }
}

}  // namespace
}  // namespace mote::test
