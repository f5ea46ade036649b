// SPDX-License-Identifier: GPL-3.0-or-later
//
// Stippled photographs and stippled layers, from files to pictures and sheets, through the real programs.
//
// OpenImageIO's header undoes macros that protobuf's need: it comes after them.
#include "tests/unit/stipple/small_hierarchy.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "tests/e2e/station.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

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
