// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films of a view and its moves.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "protocol/scene/view.h"
#include "tests/unit/scene/film_scripts.h"

namespace mote::test {
namespace {

constexpr std::string_view beam =
    "'view': {'width': 64, 'height': 48, 'camera': {'eye': [0, 3, 4], 'target': [0, 0, 0]},"
    "'layers': [{'dataset': 'a/beam', 'particles': {}, 'step': 1}, {'dataset': 'a/beam', 'ink': {}, 'step': "
    "1}]}";

proto::Script moves(std::string_view list, std::string_view more = "") {
    return scriptOf("{" + std::string(beam) + ", 'moves': [" + std::string(list) + "]" + std::string(more) +
                    "}");
}

View movedViewAt(const Film& film, double seconds) {
    return parseView(film.at(seconds)).value();
}

TEST(FilmMoves, AWholeTurnClosesItsLoop) {
    Random random(61);
    for (int i = 0; i < 100; ++i) {
        auto script = moves("{'seconds': 3, 'turn': {'degrees': 360}}");
        const glm::dvec3 axis = random.direction();
        if (i % 2) script.mutable_moves(0)->mutable_turn()->mutable_axis()->Assign(&axis.x, &axis.x + 3);
        script.set_fps(random.oneOf({7.0, 24.0, 30.0, 59.94}));
        const Film film = filmOf(script);
        EXPECT_EQ(film.frameCount(), static_cast<std::size_t>(std::llround(3.0 * film.fps())));
        const auto first = cameraAt(film, 0.0);
        const auto beyond = cameraAt(film, film.secondsOf(film.frameCount()));
        EXPECT_LT(glm::distance(beyond.eye, first.eye), 1e-9);
        EXPECT_LT(glm::distance(beyond.up, first.up), 1e-9);
        // The step from the last frame to the first is as long as any.
        const auto stepAfter = [&](std::size_t frame) {
            const auto a = cameraAt(film, film.secondsOf(frame));
            const auto b = cameraAt(film, film.secondsOf((frame + 1) % film.frameCount()));
            return glm::distance(a.eye, b.eye);
        };
        for (std::size_t frame = 0; frame < film.frameCount(); ++frame)
            EXPECT_NEAR(stepAfter(frame), stepAfter(0), 1e-9);
    }
}

TEST(FilmMoves, TurnsRightHandedAboutUp) {
    const Film film = filmOf(moves("{'seconds': 2, 'turn': {'degrees': 90}}"));
    const auto camera = cameraAt(film, 2.0);
    EXPECT_LT(glm::distance(camera.eye, glm::dvec3(4.0, 3.0, 0.0)), 1e-12);
    EXPECT_LT(glm::distance(camera.up, glm::dvec3(0.0, 1.0, 0.0)), 1e-12);
    EXPECT_EQ(cameraAt(film, 0.0).eye, glm::dvec3(0.0, 3.0, 4.0));
}

TEST(FilmMoves, EachBeginsWhereTheOneBeforeEnded) {
    const Film film =
        filmOf(moves("{'seconds': 1, 'turn': {'degrees': 90}}, {'seconds': 1, 'hold': {}}, {'seconds': 1, "
                     "'turn': {'degrees': 90}}"));
    EXPECT_EQ(film.frameCount(), 90U);
    EXPECT_EQ(film.seconds(), 3.0);
    EXPECT_LT(glm::distance(cameraAt(film, 1.5).eye, glm::dvec3(4.0, 3.0, 0.0)), 1e-12);
    EXPECT_LT(glm::distance(cameraAt(film, 3.0).eye, glm::dvec3(0.0, 3.0, -4.0)), 1e-12);
}

TEST(FilmMoves, PlaysEachStepEquallyLong) {
    const auto script =
        moves("{'seconds': 2, 'playSteps': {'from': 0, 'to': 4}}, {'seconds': 1, 'hold': {}}");
    const Film film = filmOf(script, 5);
    std::vector<int> shown(5);
    for (std::size_t i = 0; i < 60; ++i) {
        const View view = movedViewAt(film, film.secondsOf(i));
        ASSERT_EQ(view.layers.size(), 2U);
        EXPECT_EQ(view.layers[0].step, view.layers[1].step);
        ++shown[view.layers[0].step];
    }
    EXPECT_EQ(shown, (std::vector<int>{12, 12, 12, 12, 12}));
    EXPECT_EQ(movedViewAt(film, 2.5).layers[0].step, 4U) << "where it ended";
    EXPECT_EQ(movedViewAt(filmOf(moves("{'seconds': 1, 'turn': {'degrees': 9}}"), 5), 0.5).layers[0].step, 1U)
        << "the view's own";
}

TEST(FilmMoves, BlendsSteps) {
    const Film film =
        filmOf(moves("{'seconds': 4, 'playSteps': {'from': 3, 'to': 0}}", ", 'betweenSteps': 'blend'"), 5);
    const View view = movedViewAt(film, 1.25);
    ASSERT_EQ(view.layers.size(), 2U);
    EXPECT_EQ(view.layers[0].step, 3U);
    ASSERT_TRUE(view.layers[0].towards);
    EXPECT_EQ(view.layers[0].towards->step, 2U);
    EXPECT_NEAR(view.layers[0].towards->share, 0.75, 1e-12);
    EXPECT_EQ(view.layers[0].opacity, 1.0);
    EXPECT_EQ(view.layers[1].step, 2U) << "ink is drawn of one step";
    EXPECT_FALSE(movedViewAt(film, 0.25).layers[0].towards) << "its own is shown before the first half";
}

TEST(FilmMoves, AViewBetweenStepsStaysThereUntilItsStepsArePlayed) {
    auto script = moves(
        "{'seconds': 1, 'hold': {}}, {'seconds': 1, 'playSteps': {'from': 3, 'to': 3}}, {'seconds': 1, "
        "'hold': {}}");
    auto& towards = *script.mutable_view()->mutable_layers(0)->mutable_towards();
    towards.set_step(4);
    towards.set_share(0.4);
    const Film film = filmOf(script, 5);
    EXPECT_EQ(movedViewAt(film, 0.5).layers[0].towards, (Towards{4, 0.4}));
    EXPECT_FALSE(movedViewAt(film, 1.5).layers[0].towards);
    EXPECT_EQ(movedViewAt(film, 1.5).layers[0].step, 3U);
    EXPECT_FALSE(movedViewAt(film, 2.5).layers[0].towards);
    EXPECT_EQ(movedViewAt(film, 2.5).layers[0].step, 3U);
    towards.set_step(5);
    const auto none = Film::create(script, datasetsFor(script, 5));
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().where, "view.layers[0].towards.step");
}

TEST(FilmMoves, ZoomsEvenlyInTheLogarithm) {
    Film film = filmOf(moves("{'seconds': 2, 'zoomTo': {'target': [0, 0, 4], 'factor': 4}}"));
    auto camera = cameraAt(film, 1.0);
    EXPECT_LT(glm::distance(camera.target, glm::dvec3(0.0, 0.0, 2.0)), 1e-12);
    EXPECT_NEAR(glm::distance(camera.eye, camera.target), 2.5, 1e-12);
    EXPECT_NEAR(glm::distance(cameraAt(film, 2.0).eye, cameraAt(film, 2.0).target), 1.25, 1e-12);
    auto script = moves("{'seconds': 2, 'zoomTo': {'factor': 4}}");
    script.mutable_view()->mutable_camera()->set_orthographic_height(8.0);
    film = filmOf(script);
    camera = cameraAt(film, 1.0);
    EXPECT_NEAR(*camera.orthographicHeight, 4.0, 1e-12);
    EXPECT_EQ(camera.eye, glm::dvec3(0.0, 3.0, 4.0));
}

TEST(FilmMoves, DoAllAtOnce) {
    const Film film =
        filmOf(moves("{'seconds': 1, 'easing': 'smooth', 'turn': {'degrees': 180}, 'zoomTo': {'factor': 2},"
                     "'playSteps': {'from': 0, 'to': 1}}"),
               2);
    const View view = movedViewAt(film, 0.25);  // 0.15625 of it
    EXPECT_NEAR(glm::distance(view.camera.eye, view.camera.target), 5.0 * std::exp2(-0.15625), 1e-12);
    const double angle = 0.15625 * glm::pi<double>();
    EXPECT_NEAR(std::atan2(view.camera.eye.x, view.camera.eye.z), angle, 1e-12);
    EXPECT_EQ(view.layers[0].step, 0U);
    EXPECT_EQ(movedViewAt(film, 0.51).layers[0].step, 1U);
}

TEST(FilmMoves, PlayOnlyWhatIsThere) {
    const auto errorOf = [](const proto::Script& script, int steps) {
        const auto film = Film::create(script, datasetsFor(script, steps));
        return film.ok() ? "" : film.error().toString();
    };
    EXPECT_EQ(
        errorOf(moves("{'seconds': 1, 'hold': {}}, {'seconds': 1, 'playSteps': {'from': 0, 'to': 5}}"), 5),
        "moves[1].playSteps.to: \"a/beam\" has 5 steps, numbered from 0; there is no step 5");
    EXPECT_EQ(errorOf(moves("{'seconds': 1, 'playSteps': {'from': 0, 'to': 1, 'dataset': 'a/none'}}"), 5),
              "moves[0].playSteps.dataset: no layer of the view shows \"a/none\"");
    auto script = moves("{'seconds': 1, 'playSteps': {}}");
    for (auto& layer : *script.mutable_view()->mutable_layers()) layer.clear_step();
    EXPECT_EQ(errorOf(script, 0),
              "moves[0].playSteps.dataset: what the view shows has no steps to be played");
    EXPECT_EQ(
        errorOf(moves("{'seconds': 1, 'zoomTo': {'target': [0, 0, 9e11], 'factor': 1e9}}"), 5).substr(0, 16),
        "moves[0].zoomTo:");
}

TEST(FilmMoves, BlendedStepsTakeNoMoreRoom) {
    auto script = moves("{'seconds': 1, 'playSteps': {'from': 0, 'to': 1}}", ", 'betweenSteps': 'blend'");
    while (script.view().layers_size() < View::maxLayers)
        *script.mutable_view()->add_layers() = proto::Layer(script.view().layers(0));
    EXPECT_EQ(movedViewAt(filmOf(script), 0.5).layers.size(), static_cast<std::size_t>(View::maxLayers));
}

}  // namespace
}  // namespace mote::test
