// SPDX-License-Identifier: GPL-3.0-or-later
//
// A stippled surface from its dataset to picture files, alone and around the beam.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "protocol/scene/srgb.h"
#include "tests/e2e/station.h"
#include "tests/support/ball_surface.h"
#include "tests/support/image.h"

namespace mote::test {
namespace {

using testing::HasSubstr;

/// 300 x 300 pixels, in which the unit ball fills a circle of radius 100.
std::string ballView(const std::string& style, const std::string& before = "") {
    return "{'width': 300, 'height': 300, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0], "
           "'orthographicHeight': 3}, 'layers': [" +
           before + "{'dataset': 'data/ball', 'stipple': {" + style + "}}]}";
}

class Stipples : public testing::Test {
  protected:
    void SetUp() override {
        writeBall(station_.root() / "ball.mote", 20000);
        station_.startServer();
    }

    Image picture(const std::string& name) const { return readPng(station_.out() / name).value(); }

    Station station_;
};

/// Pixels brighter than the background, in and out of the ball's circle.
struct Lit {
    int inside = 0, outside = 0;
};

Lit litIn(const Image& image) {
    Lit lit;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            if (image.pixels[4 * (std::size_t{y} * image.width + x)] < 64) continue;
            // A dot's radius and half a pixel beyond the ball, and what jitter lifts it off.
            (std::hypot(x - 149.5, y - 149.5) < 104.0 ? lit.inside : lit.outside) += 1;
        }
    }
    return lit;
}

TEST_F(Stipples, AreDrawnOnTheSurface) {
    const auto done = station_.frames(
        scriptOf({ballView("'spacingPixels': 6"), ballView("'spacingPixels': 6, 'soft': true"),
                  "{'width': 300, 'height': 300, 'layers': [{'dataset': 'data/ball', 'stipple': {}}]}"}));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto lit = litIn(picture("frame-000000.png"));
    EXPECT_GT(lit.inside, 1000);
    EXPECT_EQ(lit.outside, 0);
    // A script's pictures are at rest.
    EXPECT_TRUE(picture("frame-000000.png").pixels == picture("frame-000001.png").pixels);
    EXPECT_GT(litIn(picture("frame-000002.png")).inside, 1000);  // framed
}

TEST_F(Stipples, ShareTheirDepthWithTheBeam) {
    const std::string beam = "{'dataset': 'data/beam', 'particles': {}}, ";
    const auto done =
        station_.frames(scriptOf({ballView("'spacingPixels': 6"), ballView("'spacingPixels': 6", beam),
                                  ballView("'spacingPixels': 6, 'seeThrough': true", beam)}));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto alone = litIn(picture("frame-000000.png")), both = litIn(picture("frame-000001.png"));
    EXPECT_GT(both.inside, alone.inside);
    EXPECT_GT(litIn(picture("frame-000002.png")).inside, both.inside);  // the far side of the ball, too
}

TEST_F(Stipples, LieOnTheMeshThatHidesWhatIsBehindIt) {
    writeBallMesh(station_.root() / "solid.mote");
    const auto solid = [](const char* style) {
        return "{'dataset': 'data/solid', 'mesh': {'color': [0.5, 0.5, 0.5], 'light': {'ambient': 1}" +
               std::string(style) + "}}, ";
    };
    const auto through = std::string("'seeThrough': true, 'spacingPixels': 6, 'dotPixels': 2");
    const auto done =
        station_.frames(scriptOf({ballView(through, solid("")), ballView(through, solid(", 'opacity': 0.1")),
                                  ballView("'opacity': 0", solid(""))}));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto whole = litIn(picture("frame-000002.png"));
    EXPECT_NEAR(whole.inside, 3.14159 * 100.0 * 100.0, 400.0);
    EXPECT_EQ(whole.outside, 0);
    // Dots are white.
    const auto dots = [&](const char* name) {
        const auto image = picture(name);
        int white = 0;
        for (std::size_t i = 0; i < image.pixels.size(); i += 4) white += image.pixels[i] > 200 ? 1 : 0;
        return white;
    };
    EXPECT_GT(dots("frame-000001.png"), 1.5 * dots("frame-000000.png"));
}

double meanLight(const Image& image) {
    double sum = 0.0;
    for (std::size_t i = 0; i < image.pixels.size(); i += 4)
        sum += srgbToLinear(static_cast<double>(image.pixels[i]) / 255.0);
    return 4.0 * sum / static_cast<double>(image.pixels.size());
}

TEST_F(Stipples, LookAlikeAtAnySize) {
    const auto script = scriptOf({ballView("'spacingPixels': 8, 'dotPixels': 3"), ballView("")});
    std::vector<double> lights;
    for (const char* size : {"300x300", "600x600", "1200x1200"}) {
        const auto done = station_.frames(script, {"--size", size});
        ASSERT_EQ(done.status, 0) << done.errors;
        EXPECT_EQ(std::to_string(picture("frame-000000.png").width),
                  std::string(size).substr(0, std::string(size).find('x')));
        for (const char* name : {"frame-000000.png", "frame-000001.png"})
            lights.push_back(meanLight(picture(name)));
    }
    // Dots are the same, but for those whose places are told to half as many pixels.
    for (std::size_t i = 2; i < lights.size(); ++i)
        EXPECT_NEAR(lights[i], lights[i % 2], 0.05 * lights[i % 2]);
    EXPECT_THAT(station_.frames(script, {"--size", "300"}).errors, HasSubstr("--size"));
    EXPECT_THAT(station_.frames(script, {"--size", "16000x16000"}).errors, HasSubstr("views[0].width"));
}

TEST_F(Stipples, SayWhatIsWrong) {
    const auto refused = [&](const std::string& view, const char* place) {
        const auto done = station_.frames(scriptOf({view}));
        EXPECT_EQ(done.status, 1);
        EXPECT_THAT(done.errors, HasSubstr(place));
    };
    refused(ballView("'dotPixels': -1"), "stipple.dotPixels");
    refused("{'width': 30, 'height': 30, 'layers': [{'dataset': 'data/beam', 'stipple': {}}]}", "beam");
    refused("{'width': 30, 'height': 30, 'layers': [{'dataset': 'data/ball', 'particles': {}}]}", "ball");
    refused("{'width': 30, 'height': 30, 'layers': [{'dataset': 'data/beam', 'mesh': {}}]}", "not a mesh");
    refused("{'width': 30, 'height': 30, 'layers': [{'dataset': 'data/ball', 'mesh': {'opacity': 2}}]}",
            "mesh.opacity");
}

}  // namespace
}  // namespace mote::test
