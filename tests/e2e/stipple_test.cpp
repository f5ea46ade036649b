// SPDX-License-Identifier: GPL-3.0-or-later
//
// A stippled surface from its dataset to picture files, alone and around the beam.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "protocol/scene/srgb.h"
#include "tests/e2e/station.h"
#include "tests/support/ball_surface.h"
#include "tests/support/image.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::test {
namespace {

using testing::HasSubstr;

/// 300 x 300 pixels, in which the unit ball fills a circle of radius 100.
std::string dottedBallView(const std::string& style, const std::string& before = "") {
    return "{'width': 300, 'height': 300, 'background': [0, 0, 0], 'camera': {'eye': [0, 0, 4], 'target': "
           "[0, 0, 0], "
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
        scriptOf({dottedBallView("'spacingPixels': 6"), dottedBallView("'spacingPixels': 6, 'soft': true"),
                  "{'width': 300, 'height': 300, 'background': [0, 0, 0], 'layers': [{'dataset': "
                  "'data/ball', 'stipple': {}}]}"}));
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
    const auto done = station_.frames(
        scriptOf({dottedBallView("'spacingPixels': 6"), dottedBallView("'spacingPixels': 6", beam),
                  dottedBallView("'spacingPixels': 6, 'seeThrough': true", beam)}));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto alone = litIn(picture("frame-000000.png")), both = litIn(picture("frame-000001.png"));
    EXPECT_GT(both.inside, alone.inside);
    EXPECT_GT(litIn(picture("frame-000002.png")).inside, both.inside);  // the far side of the ball, too
}

/// The surface under the dots, as a drawing or as a mesh.
TEST_F(Stipples, HaveSilhouettesWhereTheyAreAskedFor) {
    const std::string lines = "{'dataset': 'data/ball', 'ink': {'hatch': {'strength': 0}}}, ";
    const auto done = station_.frames(
        scriptOf({dottedBallView("'spacingPixels': 12"), dottedBallView("'spacingPixels': 12", lines),
                  "{'width': 300, 'height': 300, 'layers': [{'dataset': 'data/ball', 'mesh': {}}]}"}));
    ASSERT_EQ(done.status, 0) << done.errors;
    // Of 72 parts of the rim, how many have any light.
    const auto litParts = [](const Image& image) {
        std::set<int> parts;
        for (std::uint32_t y = 0; y < image.height; ++y) {
            for (std::uint32_t x = 0; x < image.width; ++x) {
                if (image.pixels[4 * (std::size_t{y} * image.width + x)] < 64) continue;
                const double across = x - 149.5, down = y - 149.5;
                if (std::abs(std::hypot(across, down) - 100.0) > 1.5) continue;
                parts.insert(
                    static_cast<int>(std::floor(36.0 * std::atan2(down, across) / std::numbers::pi)));
            }
        }
        return parts.size();
    };
    EXPECT_LT(litParts(picture("frame-000000.png")), 60U);
    EXPECT_GE(litParts(picture("frame-000001.png")), 72U);
    EXPECT_GT(litIn(picture("frame-000002.png")).inside, 20000);
}

TEST_F(Stipples, LieOnTheMeshThatHidesWhatIsBehindIt) {
    writeBallMesh(station_.root() / "solid.mote");
    const auto solid = [](const char* style) {
        return "{'dataset': 'data/solid', 'mesh': {'color': [0.5, 0.5, 0.5], 'light': {'ambient': 1}" +
               std::string(style) + "}}, ";
    };
    const auto through = std::string("'seeThrough': true, 'spacingPixels': 6, 'dotPixels': 2");
    const auto done = station_.frames(
        scriptOf({dottedBallView(through, solid("")), dottedBallView(through, solid(", 'opacity': 0.1")),
                  dottedBallView("'opacity': 0", solid(""))}));
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
    const auto script = scriptOf({dottedBallView("'spacingPixels': 8, 'dotPixels': 3"), dottedBallView("")});
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
    refused(dottedBallView("'dotPixels': -1"), "stipple.dotPixels");
    refused("{'width': 30, 'height': 30, 'layers': [{'dataset': 'data/beam', 'stipple': {}}]}", "beam");
    refused("{'width': 30, 'height': 30, 'layers': [{'dataset': 'data/ball', 'particles': {}}]}", "ball");
    refused("{'width': 30, 'height': 30, 'layers': [{'dataset': 'data/beam', 'mesh': {}}]}", "not a mesh");
    refused("{'width': 30, 'height': 30, 'layers': [{'dataset': 'data/ball', 'mesh': {'opacity': 2}}]}",
            "mesh.opacity");
}

// Stippled photographs and stippled layers, from files to pictures and sheets, through the real programs.
//
// OpenImageIO's header undoes macros that protobuf's need: it comes after them.

namespace fs = std::filesystem;

/// A picture whose left half is black and whose right half is white.
void writeHalves(const fs::path& path) {
    const OIIO::ImageSpec spec(200, 100, 1, OIIO::TypeDesc::UINT8);
    std::vector<float> values(200 * 100);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 200 < 100 ? 0.0F : 1.0F;
    const auto output = OIIO::ImageOutput::create(path.string());
    ASSERT_TRUE(output && output->open(path.string(), spec));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()) && output->close());
}

/// Mean of the 8-bit values of columns [begin, end), 0 to 1.
double meanOf(const fs::path& path, int begin, int end) {
    const auto input = OIIO::ImageInput::open(path.string());
    if (!input) return -1.0;
    const auto& spec = input->spec();
    std::vector<float> values(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
    EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data()));
    double sum = 0.0;
    std::size_t count = 0;
    for (int y = 0; y < spec.height; ++y) {
        for (int x = begin; x < end; ++x) {
            sum += values[(static_cast<std::size_t>(y) * static_cast<std::size_t>(spec.width) +
                           static_cast<std::size_t>(x)) *
                          static_cast<std::size_t>(spec.nchannels)];
            ++count;
        }
    }
    return sum / static_cast<double>(count);
}

std::size_t countOf(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

class Photographs : public testing::Test {
  protected:
    void SetUp() override {
        const auto hierarchy = jitteredGrid(50);
        writeDataset(station_.root() / "plane.mote", hierarchy, manifestOf(hierarchy));
        writeHalves(station_.root() / "halves.png");
        const auto made =
            runProcess(program("mote-prep"), {"image", (station_.root() / "halves.png").string(), "--out",
                                              (station_.root() / "halves.mote").string()});
        ASSERT_EQ(made.status, 0) << made.errors;
        station_.startServer();
    }

    static std::string photograph(const std::string& more = "") {
        return fmt::format(
            "{{'width': 400, 'height': 200, 'background': [1, 1, 1], 'layers': [{{'dataset': 'data/plane', "
            "'stipple': {{'image': 'data/halves', 'spacingPixels': 8, 'dotPixels': 4{}}}}}]}}",
            more);
    }

    Station station_;
};

TEST_F(Photographs, hasItsTones) {
    const auto done = station_.frames(scriptOf({photograph(), photograph(", 'invert': true")}));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto plain = station_.out() / "frame-000000.png";
    // Full tone: dots of 4 pixels 8 apart ink pi 4 / (8^2 sqrt(3) / 2) = 0.227 of the paper, and the mean of
    // what is black or white is encoded as it is; edges of dots, a third of their area, are encoded brighter.
    EXPECT_NEAR(meanOf(plain, 20, 180), 1.0 - 0.21, 0.05);
    EXPECT_NEAR(meanOf(plain, 220, 380), 1.0, 0.001);
    const auto inverted = station_.out() / "frame-000001.png";
    EXPECT_NEAR(meanOf(inverted, 20, 180), 1.0, 0.001);
    EXPECT_NEAR(meanOf(inverted, 220, 380), 1.0 - 0.21, 0.05);
}

/// As many dots as the tone asks for: 200^2 pixels at 2 / (sqrt(3) 8^2) a pixel are 721.7.
TEST_F(Photographs, haveNoSurface) {
    const auto refused = [&](const char* dataset, const char* style) {
        return station_
            .frames(scriptOf({fmt::format(
                "{{'width': 30, 'height': 30, 'layers': [{{'dataset': 'data/{}', '{}': {{}}}}]}}", dataset,
                style)}))
            .errors;
    };
    for (const char* style : {"ink", "mesh"}) {
        EXPECT_THAT(refused("plane", style),
                    HasSubstr("the points of \"data/plane\" lie on the plane: there is no mesh"));
    }
    EXPECT_THAT(refused("halves", "ink"),
                HasSubstr("\"data/halves\" is of kind \"image\", not a mesh, a hybrid volume or particles"));
}

TEST_F(Photographs, areCirclesOnPaper) {
    const auto done =
        station_.frames(scriptOf({photograph()}), {"--format", "svg", "--page", "100x60", "--dot", "0.5"});
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto text = bytesOf(station_.out() / "frame-000000.svg");
    EXPECT_NEAR(static_cast<double>(countOf(text, "<circle ")), 722.0, 40.0);
    EXPECT_THAT(text, HasSubstr("inkscape:label=\"dots #000000\""));
    EXPECT_THAT(text, HasSubstr("r=\"0.25\""));
    EXPECT_EQ(countOf(text, "<image"), 0u);
}

TEST_F(Photographs, whatOtherLayersDrewIsStippled) {
    const auto stippled = [](const std::string& style) {
        return "{'width': 200, 'height': 150, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0], 'up': [0, 1, "
               "0]}, "
               "'layers': [{'dataset': 'data/beam', 'step': 0, 'particles': {}}, "
               "{'dataset': 'data/plane', 'stipple': {'source': 'layers', 'spacingPixels': 3, 'dotPixels': "
               "2" +
               style + "}}]}";
    };
    const auto script = scriptOf({beamView(200), stippled(""), stippled(", 'gamma': 0.4")});
    const auto done = station_.frames(script);
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto first = bytesOf(station_.out() / "frame-000001.png");
    EXPECT_NE(first, bytesOf(station_.out() / "frame-000000.png"));
    // More of it is dots where gamma makes it brighter, and there is nothing beside dots.
    EXPECT_GT(meanOf(station_.out() / "frame-000001.png", 0, 200), 0.001);
    EXPECT_GT(meanOf(station_.out() / "frame-000002.png", 0, 200),
              meanOf(station_.out() / "frame-000001.png", 0, 200));
    ASSERT_EQ(station_.frames(script).status, 0);
    EXPECT_EQ(bytesOf(station_.out() / "frame-000001.png"), first);
}

TEST_F(Photographs, wrongDatasetsAreNamed) {
    const auto expectError = [&](const std::string& script, const std::string& part) {
        const auto done = station_.frames(script);
        EXPECT_EQ(done.status, 1);
        EXPECT_THAT(done.errors, HasSubstr(part));
    };
    const std::string view = "{'width': 40, 'height': 30, 'layers': [{'dataset': 'data/";
    expectError(scriptOf({view + "halves', 'stipple': {'image': 'data/halves'}}]}"}),
                "not a stipple hierarchy");
    expectError(scriptOf({view + "plane', 'stipple': {'image': 'data/plane'}}]}"}), "not an image");
    expectError(scriptOf({view + "plane', 'stipple': {'image': 'data/none'}}]}"}), "data/none");
}

}  // namespace
}  // namespace mote::test
