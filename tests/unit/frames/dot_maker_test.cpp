// SPDX-License-Identifier: GPL-3.0-or-later
//
// The dots of stipple layers, what is remembered of them, and where a camera stands that nobody gave.
#include "server/frames/dot_maker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "server/frames/scene_maker.h"
#include "tests/support/ball_surface.h"
#include "tests/support/view_text.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::server {
namespace {

using Surface = std::shared_ptr<const render::StippleSurface>;

Surface ball() {
    return std::make_shared<const render::StippleSurface>(test::ballSurface(4000));
}

/// "test/ball" and nothing else.
class BallSource final : public StepSource {
  public:
    Result<storage::Catalogue::Entry> dataset(const std::string& name) override {
        if (name != "test/ball") return Error{ErrorCode::notFound, "dataset", name};
        auto manifest = std::make_shared<proto::Manifest>();
        manifest->set_kind("stipple");
        manifest->mutable_stipple()->set_domain(proto::StippleManifest::SURFACE);
        for (int i = 0; i < 3; ++i) {
            manifest->mutable_mesh()->add_bounds_min(-1.0);
            manifest->mutable_mesh()->add_bounds_max(1.0);
        }
        return storage::Catalogue::Entry{name, "/nowhere", std::move(manifest)};
    }
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string&, std::uint32_t) override {
        return Error{ErrorCode::notFound, "dataset", "there are no particles"};
    }
    Result<Resident> resident(const AnyLoadable&) override {
        Resident found;
        if (ready) found.value = ball();
        return found;
    }

    bool ready = false;
};

View ballView(const std::string& style, double eye = 4.0) {
    return test::viewOf("{'width': 200, 'height': 200, 'camera': {'eye': [0, 0, " + std::to_string(eye) +
                        "], 'target': [0, 0, 0]}, 'layers': [{'dataset': 'test/ball', 'stipple': {" + style +
                        "}}]}");
}

render::Dots dotsOf(const View& view, const Surface& surface, bool onTheWay, DotHistory::Layer& history) {
    return surfaceDots(view, view.layers[0], surface, onTheWay, history);
}

TEST(DotMaker, SoftDotsComeToRestWhereExactOnesAre) {
    const auto surface = ball();
    DotHistory::Layer soft, hard;
    dotsOf(ballView("'spacingPixels': 8, 'soft': true"), surface, true, soft);
    EXPECT_TRUE(soft.points.settled());
    const auto nearer = ballView("'spacingPixels': 8, 'soft': true", 2.5);
    int pictures = 0;
    render::Dots dots;
    do {
        dots = dotsOf(nearer, surface, true, soft);
        const bool faint =
            std::any_of(dots.begin(), dots.end(), [](const auto& dot) { return dot.opacity < 1; });
        EXPECT_FALSE(faint && soft.points.settled());
    } while (!soft.points.settled() && ++pictures < 20);
    EXPECT_GT(pictures, 1);
    EXPECT_GT(dots.size(), 50U);
    EXPECT_EQ(dots, dotsOf(nearer, surface, false, hard));  // the exact picture does not wait
    EXPECT_EQ(dots, dotsOf(ballView("'spacingPixels': 8", 2.5), surface, true, hard));
}

TEST(DotMaker, WhatIsNoLongerSoftIsAtRest) {
    const auto surface = ball();
    DotHistory history{{{}}};
    dotsOf(ballView("'soft': true"), surface, true, history.layers[0]);
    dotsOf(ballView("'soft': true", 2.5), surface, true, history.layers[0]);
    EXPECT_FALSE(history.settled());
    dotsOf(ballView("", 2.5), surface, true, history.layers[0]);
    EXPECT_TRUE(history.settled());
}

TEST(DotMaker, AnotherSurfaceBeginsAnew) {
    auto surface = ball();
    DotHistory history{{{}}};
    dotsOf(ballView("'soft': true"), surface, true, history.layers[0]);
    dotsOf(ballView("'soft': true", 2.5), surface, true, history.layers[0]);
    EXPECT_FALSE(history.settled());
    surface.reset();
    EXPECT_TRUE(history.layers[0].surface.expired()) << "what is remembered keeps no data in memory";
    dotsOf(ballView("'soft': true", 2.5), ball(), true, history.layers[0]);
    EXPECT_TRUE(history.settled());
}

TEST(DotMaker, FitsACameraThatNobodyGave) {
    BallSource source;
    auto view = test::viewOf(
        "{'width': 200, 'height': 100, 'layers': [{'dataset': 'test/ball', 'transform': "
        "[3, 0, 0, 7,  0, 3, 0, 0,  0, 0, 3, 0,  0, 0, 0, 1], 'stipple': {}}]}");
    EXPECT_EQ(fitLayers(view, source).value(), false) << "its surface is on its way";
    source.ready = true;
    EXPECT_EQ(fitLayers(view, source).value(), true);
    // The ball is hardly larger than its points' hull, and seen in perspective.
    const glm::dvec3 off = view.camera.target - glm::dvec3(7.0, 0.0, 0.0);
    EXPECT_LT(glm::length(glm::cross(off, glm::normalize(view.camera.eye - view.camera.target))), 0.05);
    ASSERT_TRUE(view.shown.at(0));
    EXPECT_NEAR(view.shown[0]->max.x, 1.0, 0.02);
    const auto given = ballView("");
    auto same = given;
    EXPECT_EQ(fitLayers(same, source).value(), true);
    EXPECT_EQ(same.camera, given.camera);
}

TEST(DotMaker, PhotographsAreDrawnOnceAndKeepNothing) {
    const auto tiles = std::make_shared<const render::PlaneTiles>(
        std::make_shared<const storage::StippleHierarchy>(test::jitteredGrid(8)));
    auto image = std::make_shared<const render::PixelMap>(2, 1, std::vector<float>{0.0F, 1.0F});
    View view;
    view.width = 40;
    view.height = 20;
    DrawnPhotographs drawn;
    const auto dots = [&] {
        return drawn.dots(tiles, image, view, parseStippleStyle({}, glm::dvec3(0.0)).value(),
                          render::quickPhotograph);
    };
    const auto first = dots();
    EXPECT_EQ(dots(), first);
    view.width = 50;
    const auto wider = dots();
    EXPECT_NE(wider, first);
    const std::weak_ptr<const render::PixelMap> held = image;
    image = std::make_shared<const render::PixelMap>(2, 1, std::vector<float>{0.0F, 1.0F});
    EXPECT_TRUE(held.expired());
    EXPECT_NE(dots(), wider) << "another image";
}

}  // namespace
}  // namespace mote::server
