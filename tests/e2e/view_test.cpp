// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-view in a real window of a virtual display, against a real server.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "tests/e2e/station.h"
#include "tests/support/ball_surface.h"
#include "tests/support/image.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::test {
namespace {

using testing::HasSubstr;

/// A virtual display that chooses its own number.
class Display {
  public:
    Display() : xvfb_("/usr/bin/Xvfb", {"-displayfd", "1", "-screen", "0", "1280x800x24", "-noreset"}) {
        if (!xvfb_.waitForOutput("\n")) throw std::runtime_error("Xvfb: " + xvfb_.errors());
        name_ = ":" + xvfb_.output().substr(0, xvfb_.output().find('\n'));
    }
    ProcessOptions options() const { return {{{"DISPLAY", name_}}, {}}; }

  private:
    Process xvfb_;
    std::string name_;
};

/// Pixels left of the panel and on it that differ from the picture's black and the panel's ground.
struct Seen {
    int picture = 0;
    int panel = 0;
};

Seen seenIn(const Image& image, std::uint32_t panelBegin) {
    Seen seen;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const std::uint8_t* pixel = &image.pixels[4 * (static_cast<std::size_t>(y) * image.width + x)];
            const bool bright = pixel[0] > 60 || pixel[1] > 60 || pixel[2] > 60;
            (x < panelBegin ? seen.picture : seen.panel) += bright ? 1 : 0;
        }
    }
    return seen;
}

/// A saved view; apostrophes stand for quotation marks.
std::string saved(std::string view) {
    std::replace(view.begin(), view.end(), '\'', '"');
    return view;
}

/// Films of "data/beam" seen from these distances, a keyframe each, `seconds` apart.
std::string beamFilm(const std::vector<double>& distances, double seconds) {
    std::string script;
    for (std::size_t i = 0; i < distances.size(); ++i) {
        script += fmt::format("{}{{'seconds': {}, 'view': {}}}", i > 0 ? ", " : "",
                              seconds * static_cast<double>(i), beamView(640, 0, distances[i]));
    }
    return saved(fmt::format("{{'fps': 30, 'keyframes': [{}]}}", script));
}

/// Runs of columns in which something warm is drawn (the beam, what is selected; no grey and no blue), apart
/// by 60 columns at least, between these rows.
int warmRuns(const Image& image, std::uint32_t top, std::uint32_t bottom, std::uint32_t right) {
    constexpr std::uint32_t apart = 60;
    int runs = 0;
    std::uint32_t last = 0;
    for (std::uint32_t x = 0; x < right; ++x) {
        bool warm = false;
        for (std::uint32_t y = top; y < bottom; ++y) {
            const std::uint8_t* pixel = &image.pixels[4 * (static_cast<std::size_t>(y) * image.width + x)];
            warm |= pixel[0] > 90 && pixel[0] > pixel[2] + 40;
        }
        if (!warm) continue;
        if (runs == 0 || x > last + apart) ++runs;
        last = x;
    }
    return runs;
}

class View : public testing::Test {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists("/usr/bin/Xvfb")) GTEST_SKIP() << "Xvfb is not installed";
    }

    Finished view(const std::vector<std::string>& more) const {
        const Display display;
        std::vector<std::string> arguments{"--connect", station_.connection().string(), "--size", "1000x600",
                                           "--exit-after-still"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return runProcess(program("mote-view"), arguments, display.options());
    }
    /// The window's picture, 1000 x 600 pixels; a failure is a test failure, and empty.
    Image window(std::vector<std::string> more) const {
        const auto picture = station_.root() / "window.png";
        more.insert(more.end(), {"--screenshot", picture.string()});
        const auto done = view(more);
        EXPECT_EQ(done.status, 0) << done.errors;
        const auto image = readPng(picture);
        if (!image.ok()) {
            ADD_FAILURE() << image.error().toString();
            return {1000, 600, std::vector<std::uint8_t>(4 * 1000 * 600)};
        }
        return *image;
    }
    /// A file of the station, with this text in it.
    std::string file(const std::string& name, const std::string& text) const {
        const auto path = station_.root() / name;
        std::ofstream(path) << text;
        return path.string();
    }

    static constexpr std::uint32_t beside = 1000 - 340;  ///< columns left of the panel

    Station station_;
};

TEST_F(View, ShowsTheFirstDatasetAndItsControls) {
    station_.startServer();
    const auto image = window({});
    EXPECT_EQ(image.width, 1000U);
    EXPECT_EQ(image.height, 600U);
    const auto seen = seenIn(image, beside);
    EXPECT_GT(seen.picture, 1000);  // a beam of 20,000 particles covers far more
    EXPECT_GT(seen.panel, 2000);    // letters, curves, histogram
}

TEST_F(View, ShowsAStippledSurfaceAndItsControls) {
    writeBall(station_.root() / "a-ball.mote", 20000);  // the first in the catalogue
    station_.startServer();
    const auto image = window({});
    const auto seen = seenIn(image, beside);
    EXPECT_GT(seen.picture, 5000);  // framed: dots on a disc of some 400 pixels
    EXPECT_GT(seen.panel, 2000);
}

TEST_F(View, ShowsAVolumeAndItsControls) {
    writeSmallHybrid(station_.root() / "a-volume.mote", smallPoints(5), smallManifest(5, 8));
    station_.startServer();
    const auto image = window({});
    const auto seen = seenIn(image, beside);
    EXPECT_GT(seen.picture, 5000);  // framed: some of its 4 x 3 x 2 samples fill a good part of it
    EXPECT_GT(seen.panel, 2000);
}

TEST_F(View, ShowsASavedView) {
    station_.startServer();
    // Far away: the beam is a dot, so the picture differs from the fitted one.
    auto image = window({"--view", file("saved.json", saved(beamView(640, 1, 400.0)))});
    image.height = 480;  // above the triad and the time bar
    const auto seen = seenIn(image, beside);
    EXPECT_GT(seen.picture, 0);
    EXPECT_LT(seen.picture, 500);
}

/// Numbers that no float holds, a light that is not the usual one, two layers, a camera that says the least.
std::string oddView(int step = 0) {
    return saved(
        fmt::format("{{'width': 640, 'height': 480, 'background': [0.1, 0.2, 0.30000000001], "
                    "'camera': {{'eye': [0, 0, 4.000000000001], 'target': [0, 0, 1e-12]}}, 'layers': ["
                    "{{'dataset': 'data/beam', 'step': {}, 'particles': {{'points': {{'opacity': 0.1, "
                    "'sizePixels': 1.1}}}}, "
                    "'select': {{'ranges': [{{'column': 'x', 'max': 101325.001}}]}}}}, "
                    "{{'dataset': 'data/beam', 'particles': {{}}, 'opacity': 0.5}}]}}",
                    step));
}

TEST_F(View, SavesWhatItLoadedToTheByte) {
    station_.startServer();
    const auto first = station_.root() / "first.json", second = station_.root() / "second.json";
    const auto once = view({"--view", file("odd.json", oddView()), "--save-view", first.string()});
    ASSERT_EQ(once.status, 0) << once.errors;
    EXPECT_THAT(bytesOf(first), HasSubstr("4.000000000001"));
    EXPECT_THAT(bytesOf(first), HasSubstr("101325.001"));
    EXPECT_THAT(bytesOf(first), testing::Not(HasSubstr("colorMap")));
    // Its layout is ours now, and so it is the same to the byte.
    const auto twice = view({"--view", first.string(), "--save-view", second.string()});
    ASSERT_EQ(twice.status, 0) << twice.errors;
    EXPECT_EQ(bytesOf(second), bytesOf(first));
    // And a script of one.
    const auto drawn = runProcess(
        program("mote-frames"),
        {second.string(), "--connect", station_.connection().string(), "--out", station_.out().string()});
    EXPECT_EQ(drawn.status, 0) << drawn.errors;
    EXPECT_EQ(namesIn(station_.out()), std::vector<std::string>{"frame-000000.png"});
    // A file that is there stays.
    const auto again = view({"--save-view", second.string()});
    EXPECT_EQ(again.status, 1);
    EXPECT_THAT(again.errors, HasSubstr("is there already"));
    EXPECT_EQ(bytesOf(second), bytesOf(first));
}

TEST_F(View, ShowsTheFirstOfAScriptAndSaysSo) {
    station_.startServer();
    const auto kept = station_.root() / "kept.json";
    const auto script = file("script.json", "{\"views\": [" + oddView() + ", " + oddView(1) + "]}");
    const auto done = view({"--view", script, "--save-view", kept.string()});
    ASSERT_EQ(done.status, 0) << done.errors;
    EXPECT_THAT(done.errors, HasSubstr("script.json has 2 views, of which the first is shown here"));
    EXPECT_THAT(bytesOf(kept), HasSubstr("4.000000000001"));
    EXPECT_THAT(view({"--view", file("film.json", beamFilm({4.0, 6.0}, 2.0))}).errors,
                HasSubstr("a film of 2 keyframes"));
}

TEST_F(View, AStepThatIsNotThereIsAnErrorAndNoOtherStep) {
    station_.startServer();
    const auto done = view({"--view", file("odd.json", oddView(7))});
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("step"));
    EXPECT_THAT(done.errors, HasSubstr("7"));
}

TEST_F(View, ShowsWhatASavedViewSelects) {
    station_.startServer();
    auto view = beamView(640);
    const auto layer = view.find("'particles'");
    ASSERT_NE(layer, std::string::npos);
    view.insert(layer,
                "'highlight': {'selection': {'named': 'right'}, 'color': [0, 1, 1], 'sizePixels': 3}, ");
    view.insert(view.rfind('}'),
                ", 'selections': [{'name': 'right', 'selection': "
                "{'ranges': [{'column': 'x', 'min': 0}]}}]");
    const auto image = window({"--view", file("saved.json", saved(view))});
    int cyan = 0;  // the beam is warm
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < beside; ++x) {
            const std::uint8_t* pixel = &image.pixels[4 * (std::size_t{y} * image.width + x)];
            cyan += pixel[2] > 200 && pixel[1] > 200 && pixel[0] < 60 ? 1 : 0;
        }
    }
    EXPECT_GT(cyan, 500);
}

TEST_F(View, ShowsAFilmsKeyframesWithTheirPictures) {
    station_.startServer();
    const auto image = window({"--film", file("film.json", beamFilm({4.0, 6.0, 3.0}, 2.5))});
    // The bar is some 212 pixels high: controls, then the strip, then the film's controls.
    EXPECT_EQ(warmRuns(image, 600 - 165, 600 - 125, beside), 3);  // one selected, three with a beam
    EXPECT_GT(seenIn(image, beside).picture, 3000);
}

TEST_F(View, RefusesFilmsThatItCannotEdit) {
    const auto refused = [&](const std::string& script) {
        const auto done = view({"--film", file("film.json", script)});
        EXPECT_EQ(done.status, 1);
        EXPECT_THAT(done.errors, HasSubstr("film.json"));
        return done.errors;
    };
    EXPECT_THAT(refused(saved(scriptOf({beamView(640)}))), HasSubstr("keyframes"));
    EXPECT_THAT(refused(beamFilm({4.0}, 1.0)), HasSubstr("two keyframes"));
    EXPECT_THAT(refused(beamFilm({4.0, 5.0}, 0.0)), HasSubstr("keyframes[1].seconds"));
    EXPECT_THAT(refused("{'keyframes'"), HasSubstr("film.json"));
    EXPECT_THAT(view({"--film", (station_.root() / "none.json").string()}).errors, HasSubstr("none.json"));
}

TEST_F(View, SaysWhatIsWrongAndEnds) {
    const auto noServer = view({});
    EXPECT_EQ(noServer.status, 1);
    EXPECT_THAT(noServer.errors, HasSubstr("connection.json"));
    station_.startServer();
    const auto badView = view({"--view", file("broken.json", R"({"layers": [{"datset": "data/beam"}]})")});
    EXPECT_EQ(badView.status, 1);
    EXPECT_THAT(badView.errors, HasSubstr("datset"));
    const auto unknown = file("unknown.json", saved(beamView(640, 0, 4.0, "data/nothing")));
    const auto noDataset = view({"--view", unknown});
    EXPECT_EQ(noDataset.status, 1);
    EXPECT_THAT(noDataset.errors, HasSubstr("data/nothing"));
}

TEST_F(View, NeedsADisplayAndSaysSo) {
    const auto done = runProcess(program("mote-view"), {"--connect", station_.connection().string()},
                                 {{{"DISPLAY", ":9999"}, {"WAYLAND_DISPLAY", ""}}, {}});
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("mote-view"));
    EXPECT_EQ(runProcess(program("mote-view"), {"--size", "12"}).status, 2);
    EXPECT_EQ(runProcess(program("mote-view"), {"--help"}).status, 0);
}

}  // namespace
}  // namespace mote::test
