// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pages show what the screen shows, layers before and behind each other: generated scenes as SVG, PDF and
// EPS, made pixels by other people's programs, against the picture.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>

#include "protocol/scene/srgb.h"
#include "tests/e2e/station.h"
#include "tests/support/ball_surface.h"
#include "tests/support/image.h"
#include "tests/support/random.h"

namespace mote::test {
namespace {

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
