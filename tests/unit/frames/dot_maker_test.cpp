// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/dot_maker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "tests/support/ball_surface.h"
#include "tests/support/view_text.h"

namespace mote::server {
namespace {

/// "test/ball" and nothing else.
class BallSource final : public StepSource {
  public:
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string&, std::uint32_t) override {
        return Error{ErrorCode::notFound, "dataset", "there are no particles"};
    }
    Result<std::shared_ptr<const render::StippleSurface>> surface(const std::string& dataset) override {
        if (dataset != "test/ball") return StepSource::surface(dataset);
        return ball_;
    }

  private:
    std::shared_ptr<const render::StippleSurface> ball_ =
        std::make_shared<const render::StippleSurface>(test::ballSurface(4000));
};

View ballView(const std::string& style, double eye = 4.0, const std::string& dataset = "test/ball") {
    return test::viewOf("{'width': 200, 'height': 200, 'camera': {'eye': [0, 0, " + std::to_string(eye) +
                        "], 'target': [0, 0, 0]}, 'layers': [{'dataset': '" + dataset + "', 'stipple': {" +
                        style + "}}]}");
}

render::Dots dotsOf(const View& view, StepSource& source, bool onTheWay, DotHistory::Layer& history) {
    return surfaceDots(view, view.layers[0], source, onTheWay, history).value();
}

TEST(DotMaker, SoftDotsComeToRestWhereExactOnesAre) {
    BallSource source;
    DotHistory::Layer soft, hard;
    dotsOf(ballView("'spacingPixels': 8, 'soft': true"), source, true, soft);
    EXPECT_TRUE(soft.points.settled());
    const auto nearer = ballView("'spacingPixels': 8, 'soft': true", 2.5);
    int pictures = 0;
    render::Dots dots;
    do {
        dots = dotsOf(nearer, source, true, soft);
        const bool faint =
            std::any_of(dots.begin(), dots.end(), [](const auto& dot) { return dot.opacity < 1; });
        EXPECT_FALSE(faint && soft.points.settled());
    } while (!soft.points.settled() && ++pictures < 20);
    EXPECT_GT(pictures, 1);
    EXPECT_GT(dots.size(), 50U);
    EXPECT_EQ(dots, dotsOf(nearer, source, false, hard));  // the exact picture does not wait
    EXPECT_EQ(dots, dotsOf(ballView("'spacingPixels': 8", 2.5), source, true, hard));
}

TEST(DotMaker, WhatIsNoLongerSoftIsAtRest) {
    BallSource source;
    DotHistory history{{{}}};
    dotsOf(ballView("'soft': true"), source, true, history.layers[0]);
    dotsOf(ballView("'soft': true", 2.5), source, true, history.layers[0]);
    EXPECT_FALSE(history.settled());
    dotsOf(ballView("", 2.5), source, true, history.layers[0]);
    EXPECT_TRUE(history.settled());
}

TEST(DotMaker, FitsACameraThatNobodyGave) {
    BallSource source;
    auto view = test::viewOf(
        "{'width': 200, 'height': 100, 'layers': [{'dataset': 'test/ball', 'transform': "
        "[3, 0, 0, 7,  0, 3, 0, 0,  0, 0, 3, 0,  0, 0, 0, 1], 'stipple': {}}]}");
    ASSERT_TRUE(fitLayers(view, source).ok());
    EXPECT_LT(glm::distance(view.camera.target, glm::dvec3(7.0, 0.0, 0.0)), 1e-9);
    const auto given = ballView("");
    auto same = given;
    ASSERT_TRUE(fitLayers(same, source).ok());
    EXPECT_EQ(same.camera, given.camera);
}

TEST(DotMaker, AnotherKindIsAnError) {
    BallSource source;
    DotHistory::Layer history;
    const auto view = ballView("", 4.0, "test/nothing");
    const auto made = surfaceDots(view, view.layers[0], source, false, history);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().where, "dataset");
    EXPECT_EQ(made.error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace mote::server
