// SPDX-License-Identifier: GPL-3.0-or-later
//
// The films that deploy/demo makes: every script of deploy/films is a film of the demo's datasets, the halo's
// are loops, and the camera in the channel travels evenly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <regex>
#include <stdexcept>
#include <string>

#include "protocol/base/json.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/film/film.h"
#include "protocol/scene/view.h"

namespace mote::test {
namespace {

const std::filesystem::path deploy = MOTE_DEPLOY_FOLDER;

std::string demoText() {
    std::ifstream file(deploy / "demo");
    return {std::istreambuf_iterator<char>(file), {}};
}

/// How many steps deploy/demo has a run written with; 0 where it makes no such run.
int stepsOfRun(const std::string& file) {
    const std::regex order("synth beam [^\n]*--steps ([0-9]+) [^\n]*/" + file + "\\.h5\"");
    const std::string text = demoText();
    std::smatch found;
    return std::regex_search(text, found, order) ? std::stoi(found[1]) : 0;
}

FilmDatasets demoDatasets() {
    const int run = stepsOfRun("run"), channel = stepsOfRun("channel");
    return {{"data/beam", {plotBounds, run}},
            {"data/beam-xyz", {plotBounds, run}},
            {"data/channel", {plotBounds, channel}},
            {"data/pipe", {}},
            {"data/ring", {}},
            {"data/wire", {}}};
}

proto::Script scriptIn(const std::filesystem::path& path) {
    proto::Script script;
    const auto read = readJsonFile(path, script, std::size_t{1} << 20);
    EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().toString());
    return script;
}

Film filmIn(const std::filesystem::path& path) {
    auto film = Film::create(scriptIn(path), demoDatasets());
    if (!film.ok()) throw std::invalid_argument(path.string() + ": " + film.error().toString());
    return *std::move(film);
}

Camera cameraOf(const Film& film, std::size_t frame) {
    return parseView(film.frame(frame)).value().camera;
}

double wayOfEye(const Film& film, std::size_t from, std::size_t to) {
    return glm::distance(cameraOf(film, from).eye, cameraOf(film, to).eye);
}

TEST(Films, AreFilmsOfTheDemosDatasets) {
    ASSERT_EQ(stepsOfRun("run"), 6);
    ASSERT_GT(stepsOfRun("channel"), 100);
    int films = 0;
    for (const auto& entry : std::filesystem::directory_iterator(deploy / "films")) {
        if (entry.path().extension() != ".json") continue;
        ++films;
        const auto name = entry.path().filename().string();
        const auto script = scriptIn(entry.path());
        const auto checked = checkScript(script);
        ASSERT_TRUE(checked.ok()) << name << ": " << checked.error().toString();
        const Film film = filmIn(entry.path());
        EXPECT_TRUE(film.continuous()) << name;
        EXPECT_GE(film.frameCount(), 60U) << name;
        EXPECT_LE(film.frameCount(), 600U) << name;
        for (std::size_t i = 0; i < film.frameCount(); ++i) {
            const auto view = parseView(film.frame(i));
            ASSERT_TRUE(view.ok()) << name << " frame " << i << ": " << view.error().toString();
            ASSERT_FALSE(view->layers.empty()) << name << " frame " << i;
            ASSERT_EQ(view->width % 2, 0U) << name << ": MP4 has even sizes";
            ASSERT_EQ(view->height % 2, 0U) << name;
        }
    }
    EXPECT_GE(films, 5);
}

/// deploy/demo names each film that it makes.
TEST(Films, AreMadeByTheDemo) {
    for (const auto* name : {"exploration", "halo", "channel", "drawing"}) {
        EXPECT_TRUE(std::filesystem::exists(deploy / "films" / (std::string(name) + ".json"))) << name;
        EXPECT_TRUE(std::regex_search(demoText(), std::regex("for name in [^\n]*\\b" + std::string(name))))
            << name;
    }
}

TEST(Films, OfTheHaloLeadTheirLastFrameIntoTheirFirst) {
    for (const auto* name : {"halo.json", "halo-turn.json"}) {
        const Film film = filmIn(deploy / "films" / name);
        const std::size_t last = film.frameCount() - 1;
        const double step = wayOfEye(film, 0, 1);
        for (std::size_t i = 0; i < last; ++i) ASSERT_NEAR(wayOfEye(film, i, i + 1), step, 0.01 * step) << i;
        EXPECT_NEAR(wayOfEye(film, last, 0), step, 0.01 * step) << name;
        const auto knot = [&](std::size_t frame) {
            return film.frame(frame).layers(0).particles().volume().curve(0).density();
        };
        double most = 0.0;
        for (std::size_t i = 0; i < last; ++i) most = std::max(most, std::abs(knot(i + 1) - knot(i)));
        EXPECT_GT(most, 0.0) << name << ": the transfer function changes";
        EXPECT_LE(std::abs(knot(last) - knot(0)), 1.01 * most) << name;
    }
}

TEST(Films, OfTheChannelTravelsEvenlyThroughAllSteps) {
    const Film film = filmIn(deploy / "films" / "channel.json");
    const std::size_t last = film.frameCount() - 1;
    double way = 0.0;
    for (std::size_t i = 0; i < last; ++i) way += wayOfEye(film, i, i + 1);
    const double mean = way / static_cast<double>(last);
    for (std::size_t i = 0; i < last; ++i) EXPECT_NEAR(wayOfEye(film, i, i + 1), mean, 0.02 * mean) << i;
    EXPECT_EQ(film.frame(0).layers(0).step(), 0U);
    EXPECT_EQ(film.frame(last).layers(0).step() + 1, static_cast<std::uint32_t>(stepsOfRun("channel")));
}

}  // namespace
}  // namespace mote::test
