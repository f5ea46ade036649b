// SPDX-License-Identifier: GPL-3.0-or-later
//
// A drawing in pen and ink from its dataset to picture files and sheets.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>

#include "protocol/scene/srgb.h"
#include "tests/e2e/station.h"
#include "tests/support/ball_surface.h"
#include "tests/support/image.h"
#include "tests/support/random.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// 300 x 300 pixels of white paper, on which the unit ball fills a circle of radius 100.
std::string ballView(const std::string& style, const std::string& before = "") {
    return "{'width': 300, 'height': 300, 'background': [1, 1, 1], 'camera': {'eye': [0, 0, 4], 'target': "
           "[0, 0, "
           "0], 'orthographicHeight': 3}, 'layers': [" +
           before + "{'dataset': 'data/ball', 'ink': {" + style + "}}]}";
}

class Ink : public testing::Test {
  protected:
    void SetUp() override {
        writeBallMesh(station_.root() / "ball.mote");
        station_.startServer();
    }

    Image picture(const std::string& name) const { return readPng(station_.out() / name).value(); }

    Station station_;
};

/// At least, in a part of the rim: a line of 1.2 pixels at 720 lines is half a pixel wide.
constexpr double rimOfALine = 4.0;

/// How dark what lies within a distance of the middle is, and beyond; the least dark of 24 parts of the rim.
struct Inked {
    double inside = 0.0, outside = 0.0, rim = 0.0;
};

Inked inkIn(const Image& image) {
    Inked inked;
    std::array<double, 24> rim{};
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const double dark = 1.0 - image.pixels[4 * (std::size_t{y} * image.width + x)] / 255.0;
            const double across = x - 149.5, down = y - 149.5, from = std::hypot(across, down);
            (from < 95.0    ? inked.inside
             : from > 103.0 ? inked.outside
                            : rim[static_cast<std::size_t>(12.0 + 11.999 * std::atan2(down, across) /
                                                                      std::numbers::pi)]) += dark;
        }
    }
    inked.rim = *std::min_element(rim.begin(), rim.end());
    return inked;
}

TEST_F(Ink, DrawsTheOutlineAndHatchesWhatIsDark) {
    const auto done = station_.frames(scriptOf({ballView("'hatch': {'strength': 0}"), ballView(""),
                                                ballView("'silhouettes': {'mode': 'none'}"),
                                                ballView("'light': {'ambient': 0, 'diffuse': 0}")}));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto outline = inkIn(picture("frame-000000.png")), both = inkIn(picture("frame-000001.png"));
    const auto hatches = inkIn(picture("frame-000002.png")), dark = inkIn(picture("frame-000003.png"));
    EXPECT_GT(outline.rim, rimOfALine) << "all the way round";
    EXPECT_LT(outline.inside, 1.0);
    EXPECT_LT(outline.outside, 1.0);
    EXPECT_GT(both.inside, 1000.0);
    EXPECT_LT(both.outside, 1.0);
    EXPECT_LT(hatches.rim, both.rim);
    EXPECT_GT(dark.inside, 2.0 * both.inside);
}

/// Each frame follows from the one before it, where that is not said; by one server, however many there are.
TEST_F(Ink, FilmsAreCoherentUnlessTheySayOtherwise) {
    const auto filmOf = [](const std::string& style) {
        return "{'fps': 20, 'view': " + ballView(style) +
               ", 'moves': [{'turn': {'degrees': 12}, 'seconds': 0.2}]}";
    };
    const auto last = [&](const std::string& style, const std::vector<std::string>& more) {
        const auto done = station_.frames(filmOf(style), more);
        EXPECT_EQ(done.status, 0) << done.errors;
        return picture("frame-000003.png").pixels;
    };
    const std::vector<std::string> two{
        "--spawn", "data=" + station_.root().string(), "--device", "cpu", "--jobs", "2"};
    const auto usual = last("", {});
    EXPECT_TRUE(usual == last("'coherent': true", {}));
    EXPECT_TRUE(usual == last("", two));
    const auto independent = last("'coherent': false", {});
    EXPECT_FALSE(usual == independent);
    // So does a film that the server makes.
    const std::vector<std::string> there{"--connect", station_.connection().string(), "--quiet"};
    const auto said = [&](std::vector<std::string> words) {
        words.insert(words.end(), there.begin(), there.end());
        const auto done = runProcess(program("mote-frames"), words);
        EXPECT_EQ(done.status, 0) << done.errors;
        return done.output.substr(0, 16);
    };
    const auto job = said({station_.writeScript(filmOf("")).string(), "--detach"});
    said({"--follow", job});
    said({"--fetch", job, "--out", station_.out().string()});
    EXPECT_TRUE(usual == picture("frame-000003.png").pixels);
    // A list of views is pictures by themselves.
    const auto listed = [&](const std::string& style) {
        EXPECT_EQ(station_.frames(scriptOf({ballView(style), ballView(style)})).status, 0);
        return picture("frame-000001.png").pixels;
    };
    EXPECT_TRUE(listed("") == listed("'coherent': false"));
    EXPECT_FALSE(listed("") == listed("'coherent': true"));
}

TEST_F(Ink, LiesOnItsSurface) {
    const auto surface = [](const char* opacity) {
        return std::string(
                   "{'dataset': 'data/ball', 'mesh': {'color': [1, 1, 1], 'light': {'ambient': 1}, "
                   "'opacity': ") +
               opacity + "}}, ";
    };
    const auto done = station_.frames(scriptOf({ballView(""), ballView("", surface("1"))}));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto alone = inkIn(picture("frame-000000.png")), both = inkIn(picture("frame-000001.png"));
    EXPECT_NEAR(both.inside, alone.inside, 0.02 * alone.inside);
}

TEST_F(Ink, IsShapesOnASheet) {
    for (const std::string format : {"svg", "eps", "pdf"}) {
        const auto done = station_.frames(scriptOf({ballView("")}), {"--format", format});
        ASSERT_EQ(done.status, 0) << done.errors;
        const auto text = bytesOf(station_.out() / ("frame-000000." + format));
        EXPECT_GT(text.size(), 2000U) << format;
        if (format != "svg") continue;
        EXPECT_THAT(text, HasSubstr("<path"));
        EXPECT_THAT(text, Not(HasSubstr("<image")));
    }
}

TEST_F(Ink, ShowsWhatItIsMadeFrom) {
    std::vector<std::string> views;
    for (const char* show :
         {"grey", "depth", "angle", "edges", "complexity", "segments", "target", "lighten", "darken"})
        views.push_back(ballView(std::string("'show': '") + show + "'"));
    const auto done = station_.frames(scriptOf(views));
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto grey = inkIn(picture("frame-000000.png")), depth = inkIn(picture("frame-000001.png"));
    EXPECT_LT(grey.outside, 1.0) << "paper";
    EXPECT_GT(depth.outside, 40000.0) << "nothing";
    EXPECT_GT(inkIn(picture("frame-000003.png")).rim, rimOfALine);
}

/// Share of a picture's pixels that ink covers.
double coveredOf(const Image& image) {
    double dark = 0.0;
    for (std::size_t i = 0; i < image.pixels.size(); i += 4) dark += 1.0 - image.pixels[i] / 255.0;
    return 4.0 * dark / static_cast<double>(image.pixels.size());
}

TEST_F(Ink, DrawsVolumesAndParticles) {
    writeSmallHybrid(station_.root() / "small.mote", smallPoints(5), smallManifest(5, 8));
    const auto view = [](const std::string& dataset, const std::string& style) {
        return "{'width': 200, 'height': 150, 'background': [1, 1, 1], 'layers': [{'dataset': 'data/" +
               dataset + "', 'ink': {" + style + "}}]}";
    };
    const std::string dark = "'light': {'ambient': 0.1, 'diffuse': 0.3}, ";
    const auto done = station_.frames(scriptOf(
        {view("small", dark + "'curve': [{'value': -10, 'opacity': 0.5}]"),
         view("beam", dark + "'curve': [{'value': 0, 'opacity': 0}, {'value': 0.3, 'opacity': 0.9}]"),
         view("small", "'curve': [{'value': 0, 'opacity': 0}]"), view("beam", ""),
         view("beam", "'show': 'grey'")}));
    ASSERT_EQ(done.status, 0) << done.errors;
    // A box in the middle of the view, and a beam: a good part of the picture, but not its border.
    EXPECT_GT(coveredOf(picture("frame-000000.png")), 0.1);
    EXPECT_GT(coveredOf(picture("frame-000001.png")), 0.02);
    EXPECT_EQ(coveredOf(picture("frame-000002.png")), 0.0) << "nothing is seen";
    EXPECT_LT(coveredOf(picture("frame-000003.png")), 0.5);
    EXPECT_GT(coveredOf(picture("frame-000004.png")), 0.001);
    const auto sheet = station_.frames(scriptOf({view("beam", "'curve': [{'value': 0.1, 'opacity': 0.5}]")}),
                                       {"--format", "svg"});
    ASSERT_EQ(sheet.status, 0) << sheet.errors;
    EXPECT_THAT(bytesOf(station_.out() / "frame-000000.svg"), HasSubstr("<path"));
    const auto step = station_.frames(scriptOf(
        {"{'width': 32, 'height': 24, 'layers': [{'dataset': 'data/beam', 'step': 9, 'ink': {}}]}"}));
    EXPECT_THAT(step.errors, HasSubstr("layers[0]"));
}

TEST_F(Ink, SaysWhatIsWrong) {
    const auto word = station_.frames(scriptOf({ballView("'silhouettes': {'mode': 'some'}")}));
    EXPECT_NE(word.status, 0);
    EXPECT_THAT(
        word.errors,
        HasSubstr("ink.silhouettes.mode: \"some\" is not known: there are none, all, important, adjusted"));
    const auto number = station_.frames(scriptOf({ballView("'reading': 0")}));
    EXPECT_THAT(number.errors, HasSubstr("ink.reading"));
    const auto curve = station_.frames(scriptOf({ballView("'curve': [{'value': 0, 'opacity': 1}]")}));
    EXPECT_THAT(curve.errors, HasSubstr("layers[0].ink.curve: a curve is of a volume or of particles"));
}

// Pages show what the screen shows, layers before and behind each other: generated scenes as SVG, PDF and
// EPS, made pixels by other people's programs, against the picture.

constexpr std::uint32_t width = 240, height = 180, times = 8;  // pixels of the picture; of a page for one
constexpr int dotsPerInch = 96 * times;

/// Somewhere, in half its size.
std::string anywhere(Random& random) {
    const double size = random.between(0.4, 0.8);
    return fmt::format("'transform': [{0}, 0, 0, {1}, 0, {0}, 0, {2}, 0, 0, {0}, {3}, 0, 0, 0, 1]", size,
                       random.between(-0.5, 0.5), random.between(-0.4, 0.4), random.between(-0.8, 0.8));
}

std::string anyColor(Random& random) {
    return fmt::format("[{:.3f}, {:.3f}, {:.3f}]", random.unit(), random.unit(), random.unit());
}

/// Something that is made of pixels on a page.
std::string anyMatter(Random& random) {
    if (random.chance(0.4))
        return fmt::format("{{'dataset': 'data/beam', 'particles': {{}}, {}}}", anywhere(random));
    return fmt::format("{{'dataset': 'data/solid', 'mesh': {{'color': {}, 'opacity': {}}}, {}}}",
                       anyColor(random), random.oneOf({"1", "1", "0.6", "0.3"}), anywhere(random));
}

/// Something that is made of shapes.
std::string anyShapes(Random& random) {
    if (random.chance(0.5)) {
        return fmt::format(
            "{{'dataset': 'data/solid', 'ink': {{'silhouettes': {{'width': 2}}, 'hatch': "
            "{{'spacing': 8, 'width': 1.5}}}}, {}}}",
            anywhere(random));
    }
    return fmt::format(
        "{{'dataset': 'data/ball', 'stipple': {{'spacingPixels': 8, 'dotPixels': {}, 'opacity': "
        "{}, 'seeThrough': {}, 'color': {}}}, {}}}",
        random.oneOf({"3", "5"}), random.oneOf({"1", "1", "0.5"}), random.oneOf({"true", "false"}),
        anyColor(random), anywhere(random));
}

std::string anyScene(std::uint64_t number) {
    Random random(30, number);
    const auto camera = random.oneOf({"'orthographicHeight': 3", "'fovYDegrees': 40"});
    std::string layers = anyMatter(random) + ", " + anyShapes(random);
    for (auto more = random.below(3); more > 0; --more)
        layers += ", " + (random.chance(0.5) ? anyMatter(random) : anyShapes(random));
    return fmt::format(
        "{{'width': {}, 'height': {}, 'background': {}, 'camera': {{'eye': [0, 0, 4], 'target': "
        "[0, 0, 0], {}}}, 'layers': [{}]}}",
        width, height, random.oneOf({"[1, 1, 1]", "[0, 0, 0]", "[0.6, 0.7, 0.8]"}), camera, layers);
}

/// Mean light of squares of so many pixels a side, encoded again, 0 to 255.
std::vector<double> meansOf(const Image& image, std::uint32_t side) {
    std::array<double, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = srgbToLinear(static_cast<double>(i) / 255.0);
    const std::uint32_t columns = image.width / side, rows = image.height / side;
    std::vector<double> means(std::size_t{3} * columns * rows, 0.0);
    for (std::uint32_t y = 0; y < rows * side; ++y) {
        for (std::uint32_t x = 0; x < columns * side; ++x) {
            const auto* from = &image.pixels[4 * (std::size_t{y} * image.width + x)];
            auto* const to = &means[3 * (std::size_t{y} / side * columns + x / side)];
            for (int c = 0; c < 3; ++c) to[c] += light[from[c]];
        }
    }
    for (auto& mean : means) mean = 255.0 * linearToSrgb(mean / (side * side));
    return means;
}

/// Decibels.
double likeness(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(a.size()) / std::max(sum, 1e-9));
}

class Pages : public testing::Test {
  protected:
    void SetUp() override {
        for (const char* tool : {"rsvg-convert", "pdftoppm", "gs"}) {
            if (!std::filesystem::exists(std::filesystem::path("/usr/bin") / tool))
                GTEST_SKIP() << tool << " is not installed";
        }
        writeBall(station_.root() / "ball.mote", 4000);
        writeBallMesh(station_.root() / "solid.mote");
        station_.startServer();
    }

    std::string file(int frame, const char* ending) const {
        return (station_.out() / fmt::format("frame-{:06}.{}", frame, ending)).string();
    }
    /// By another program, in `times` as many pixels on each side.
    Image rasterised(int frame, const std::string& format) const {
        const auto page = file(frame, format.c_str());
        const auto made = (station_.out() / "page.png").string();
        const auto stem = (station_.out() / "page").string();
        const auto dots = std::to_string(dotsPerInch);
        Finished done;
        if (format == "svg") {
            done =
                runProcess("/usr/bin/rsvg-convert", {"-b", "white", "-w", std::to_string(width * times), "-h",
                                                     std::to_string(height * times), "-o", made, page});
        } else if (format == "pdf") {
            done = runProcess("/usr/bin/pdftoppm", {"-r", dots, "-png", "-singlefile", page, stem});
        } else {
            done = runProcess("/usr/bin/gs",
                              {"-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", "-dEPSCrop", "-dGraphicsAlphaBits=4",
                               "-r" + dots, "-sDEVICE=png16m", "-sOutputFile=" + made, page});
        }
        EXPECT_EQ(done.status, 0) << done.errors;
        return readPng(made).value();
    }

    Station station_;
};

TEST_F(Pages, ShowWhatTheScreenShows) {
    constexpr int scenes = 12;
    // Over squares of three pixels: on the screen the edge of a stroke is a pixel wide whatever its direction
    // (docs/PICTURE.md, "Strokes"), on a page it is as wide as it seems from a square pixel. At one pixel
    // that alone is 33 to 40 dB of a dense hatching, with nothing before it.
    constexpr double bar = 40.0;  // dB
    std::vector<std::string> views;
    for (int i = 0; i < scenes; ++i) views.push_back(anyScene(static_cast<std::uint64_t>(i)));
    for (const char* format : {"png", "svg", "pdf", "eps"}) {
        const auto done = station_.frames(scriptOf(views), {"--format", format});
        ASSERT_EQ(done.status, 0) << done.errors;
    }
    for (int i = 0; i < scenes; ++i) {
        const auto picture = readPng(file(i, "png")).value();
        for (const char* format : {"svg", "pdf", "eps"}) {
            const auto page = rasterised(i, format);
            ASSERT_EQ(page.width, width * times) << format;
            ASSERT_EQ(page.height, height * times) << format;
            const double decibels = likeness(meansOf(page, 3 * times), meansOf(picture, 3));
            EXPECT_GE(decibels, bar) << format << ": " << views[static_cast<std::size_t>(i)];
            RecordProperty(fmt::format("{}-{}", format, i), fmt::format("{:.1f} dB", decibels));
        }
    }
}

}  // namespace
}  // namespace mote::test
