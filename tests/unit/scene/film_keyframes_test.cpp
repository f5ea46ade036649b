// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films of keyframes.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "protocol/base/json.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view.h"
#include "protocol/scene/view_message.h"
#include "protocol/scene/write_fields.h"
#include "tests/unit/scene/film_scripts.h"

namespace mote::test {
namespace {

View viewAt(const Film& film, double seconds) {
    return parseView(film.at(seconds)).value();
}

/// A film of two views, a second apart; apostrophes as in scriptOf().
proto::Script between(std::string_view first, std::string_view second, std::string_view more = "") {
    const auto view = [](std::string_view layers) {
        return "{'width': 64, 'height': 48, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]}, 'layers': [" +
               std::string(layers) + "]}";
    };
    return scriptOf("{'keyframes': [{'seconds': 0, 'view': " + view(first) +
                    "}, {'seconds': 1, 'view': " + view(second) + "}]" + std::string(more) + "}");
}

TEST(FilmKeyframes, FramesGoFromTheFirstToTheLast) {
    auto script = between("", "");
    script.set_fps(24.0);
    Film film = filmOf(script);
    EXPECT_TRUE(film.continuous());
    EXPECT_EQ(film.frameCount(), 25U);
    EXPECT_EQ(film.fps(), 24.0);
    EXPECT_EQ(film.width(), 64U);
    EXPECT_EQ(film.height(), 48U);
    EXPECT_EQ(film.seconds(), 1.0);
    EXPECT_NEAR(film.secondsOf(24), 1.0, 1e-12);
    script.mutable_keyframes(0)->set_seconds(-3.1);
    film = filmOf(script);
    EXPECT_EQ(film.frameCount(), 99U);
    EXPECT_EQ(film.secondsOf(0), -3.1);
    EXPECT_NEAR(film.secondsOf(98), 1.0, 1e-12);
    script.set_fps(0.1);
    EXPECT_EQ(filmOf(script).frameCount(), 1U);
}

TEST(FilmKeyframes, AKeyframesOwnTimeShowsItsView) {
    int hit = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {
        auto script = anyKeyframes(51, i);
        for (int k = 0; k < script.keyframes_size(); ++k) {
            // On frames of the film.
            script.mutable_keyframes(k)->set_seconds(-1.0 + k * 0.7);
            // With a camera that depends on no dataset.
            auto& view = *script.mutable_keyframes(k)->mutable_view();
            if (!view.has_camera()) *view.mutable_camera() = toProto(Camera{});
        }
        const Film film = filmOf(script);
        for (std::size_t frame = 0; frame < film.frameCount(); frame += 21) {
            const auto shown = film.frame(frame);
            const auto& keyframe = script.keyframes(static_cast<int>(frame / 21));
            EXPECT_EQ(shown.SerializeAsString(), keyframe.view().SerializeAsString());
            ++hit;
        }
        EXPECT_EQ(film.at(-100.0).SerializeAsString(), film.frame(0).SerializeAsString());
        EXPECT_EQ(film.at(100.0).SerializeAsString(), film.frame(film.frameCount() - 1).SerializeAsString());
    }
    EXPECT_GT(hit, 400);
}

TEST(FilmKeyframes, WithoutACameraTheyFitTheirDatasets) {
    const auto script = scriptOf(
        "{'keyframes': [{'seconds': 0, 'view': {'width': 64, 'height': 48, 'layers': ["
        "{'dataset': 'a/mesh', 'mesh': {}, 'transform': [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]},"
        "{'dataset': 'a/plane', 'stipple': {'image': 'a/picture'}}]}},"
        "{'seconds': 1, 'view': {'width': 64, 'height': 48, 'layers': [{'dataset': 'a/beam', 'particles': "
        "{}}]}}]}");
    const Bounds box{{10.0, 0.0, 0.0}, {20.0, 1.0, 1.0}};
    const FilmDatasets datasets{
        {"a/mesh", {box}}, {"a/beam", {plotBounds, 4}}, {"a/plane", {}}, {"a/picture", {}}};
    const auto film = Film::create(script, datasets);
    ASSERT_TRUE(film.ok()) << film.error().toString();
    const Bounds twice{{20.0, 0.0, 0.0}, {40.0, 2.0, 2.0}};
    EXPECT_EQ(cameraAt(*film, 0.0), fitCamera(twice, 64.0 / 48.0));
    EXPECT_EQ(cameraAt(*film, 1.0), fitCamera(plotBounds, 64.0 / 48.0));
}

TEST(FilmKeyframes, NumbersAndColoursGoEvenly) {
    const Film film =
        filmOf(between("{'dataset': 'a/b', 'opacity': 0.5, 'mesh': {'color': [0, 0, 0], 'opacity': 0.5,"
                       "'light': {'direction': [1, 0, 0], 'ambient': 0.1}}}",
                       "{'dataset': 'a/b', 'opacity': 1, 'mesh': {'color': [1, 1, 1], 'opacity': 1,"
                       "'light': {'direction': [0, 1, 0], 'ambient': 0.5}}}"));
    const View view = viewAt(film, 0.25);
    ASSERT_EQ(view.layers.size(), 1U);
    const MeshStyle& style = *view.layers[0].mesh();
    EXPECT_NEAR(view.layers[0].opacity, 0.625, 1e-12);
    EXPECT_NEAR(readColor(style.color()).x, 0.25, 1e-12) << "of the light, not of its code";
    EXPECT_NEAR(style.opacity(), 0.625, 1e-12);
    EXPECT_NEAR(style.light().ambient(), 0.2, 1e-12);
    const double angle = 0.25 * 1.5707963267948966;
    EXPECT_LT(glm::distance(readVector(style.light().direction()),
                            glm::dvec3(std::cos(angle), std::sin(angle), 0.0)),
              1e-12);
}

TEST(FilmKeyframes, WhatComesAndGoesFades) {
    const Film film = filmOf(
        between("{'dataset': 'a/goes', 'opacity': 0.8, 'mesh': {}}, {'dataset': 'a/stays', 'mesh': {}}",
                "{'dataset': 'a/stays', 'mesh': {}}, {'dataset': 'a/comes', 'mesh': {}}"));
    const View view = viewAt(film, 0.25);
    ASSERT_EQ(view.layers.size(), 3U);
    EXPECT_EQ(view.layers[0].dataset, "a/goes");
    EXPECT_NEAR(view.layers[0].opacity, 0.6, 1e-12);
    EXPECT_EQ(view.layers[1].dataset, "a/stays");
    EXPECT_EQ(view.layers[1].opacity, 1.0);
    EXPECT_EQ(view.layers[2].dataset, "a/comes");
    EXPECT_NEAR(view.layers[2].opacity, 0.25, 1e-12);
}

TEST(FilmKeyframes, LayersAreTheSameByDatasetKindAndPlaceAmongThem) {
    const Film film =
        filmOf(between("{'dataset': 'a/b', 'mesh': {'opacity': 0.2}}, {'dataset': 'a/b', 'ink': {}},"
                       "{'dataset': 'a/b', 'mesh': {'opacity': 0.8}}",
                       "{'dataset': 'a/b', 'mesh': {'opacity': 0.4}}, {'dataset': 'a/b', 'mesh': {}}"));
    const View view = viewAt(film, 0.5);
    ASSERT_EQ(view.layers.size(), 3U);
    EXPECT_NEAR(view.layers[0].mesh()->opacity(), 0.3, 1e-12);
    EXPECT_NEAR(view.layers[1].opacity, 0.5, 1e-12);
    EXPECT_NEAR(view.layers[2].mesh()->opacity(), 0.9, 1e-12);
}

TEST(FilmKeyframes, ColourMapsDissolve) {
    const Film film =
        filmOf(between("{'dataset': 'a/b', 'opacity': 0.5, 'particles': {'volume': {'colorMap': 'inferno',"
                       "'curve': [{'density': 0, 'opacity': 0}, {'density': 1, 'opacity': 0.2}]}}}",
                       "{'dataset': 'a/b', 'particles': {'volume': {'colorMap': 'viridis',"
                       "'curve': [{'density': 0.5, 'opacity': 0}, {'density': 1, 'opacity': 0.6}]}}}"));
    const View view = viewAt(film, 0.25);
    ASSERT_EQ(view.layers.size(), 2U);
    EXPECT_NEAR(view.layers[0].opacity, 0.375, 1e-12);
    EXPECT_NEAR(view.layers[1].opacity, 0.25, 1e-12);
    EXPECT_EQ(view.layers[0].particles()->volume().color_map(), "inferno");
    EXPECT_EQ(view.layers[1].particles()->volume().color_map(), "viridis");
    const auto curve = Curve::create({{0.125, 0.0}, {1.0, 0.3}}).value();
    for (const auto& layer : view.layers) {
        for (const double x : {0.1, 0.5, 1.0})
            EXPECT_NEAR(particlesStyleOf(*layer.particles()).volumeOpacity(x), curve(x), 1e-12)
                << "all else lies between in both";
        for (const double x : {0.1, 0.5, 1.0})
            EXPECT_NEAR(particlesStyleOf(*layer.particles()).pointFraction(x), linkedFraction(curve)(x),
                        1e-12);
    }
}

TEST(FilmKeyframes, WhatOneLeavesToTheDatasetDissolves) {
    for (const auto& [first, second] :
         {std::pair{"{'dataset': 'a/b', 'hybrid': {}}",
                    "{'dataset': 'a/b', 'hybrid': {'curve': [{'value': 1, 'opacity': 1}]}}"},
          {"{'dataset': 'a/b', 'hybrid': {}}", "{'dataset': 'a/b', 'hybrid': {'representation': 'volume'}}"},
          {"{'dataset': 'a/b', 'hybrid': {}}", "{'dataset': 'a/b', 'hybrid': {'pointShape': 'disc'}}"},
          {"{'dataset': 'a/b', 'hybrid': {}}",
           "{'dataset': 'a/b', 'hybrid': {'clipPlanes': [{'normal': [1, 0, 0]}]}}"},
          {"{'dataset': 'a/b', 'particles': {}}",
           "{'dataset': 'a/b', 'particles': {'points': {'opacity': 0.2}}}"},
          {"{'dataset': 'a/b', 'mesh': {}}", "{'dataset': 'a/b', 'mesh': {'wire': true}}"},
          {"{'dataset': 'a/b', 'mesh': {}}", "{'dataset': 'a/b', 'mesh': {'light': {'fixed': true}}}"},
          {"{'dataset': 'a/b', 'mesh': {}}",
           "{'dataset': 'a/b', 'mesh': {}, 'transform': [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}"},
          {"{'dataset': 'a/b', 'ink': {}}", "{'dataset': 'a/b', 'ink': {'show': 'grey'}}"},
          {"{'dataset': 'a/b', 'stipple': {}}", "{'dataset': 'a/b', 'stipple': {'invert': true}}"}}) {
        const View view = viewAt(filmOf(between(first, second)), 0.75);
        ASSERT_EQ(view.layers.size(), 2U) << second;
        EXPECT_NEAR(view.layers[0].opacity, 0.25, 1e-12);
        EXPECT_NEAR(view.layers[1].opacity, 0.75, 1e-12);
    }
}

TEST(FilmKeyframes, WhatOneLeavesToItsPlotIsSaidAsBeforeByTheOther) {
    const std::string said =
        "{'dataset': 'a/b', 'particles': {'volume': {'curve': [{'density': 0.5, 'opacity': 0.2}],"
        "'densityRange': [1, 100]}, 'points': {'sizePixels': 4, 'opacity': 0.5, 'color': [1, 0, 0]}}}";
    const Film film = filmOf(between(said, "{'dataset': 'a/b', 'particles': {}}"));
    const View view = viewAt(film, 0.25);
    ASSERT_EQ(view.layers.size(), 2U);
    EXPECT_EQ(view.layers[0].style, viewAt(film, 0.0).layers[0].style);
    EXPECT_EQ(view.layers[1].style, viewAt(film, 1.0).layers[0].style);
    EXPECT_EQ(view.layers[1].particles()->points().has_size_pixels(), false);
}

TEST(FilmKeyframes, LinkedPointsComeEvenlyWithTheirVolume) {
    const Film film = filmOf(
        between("{'dataset': 'a/b', 'particles': {'volume': {'curve': [{'density': 0, 'opacity': 0}]}}}",
                "{'dataset': 'a/b', 'particles': {'volume': {'curve': [{'density': 0.5, 'opacity': 0},"
                "{'density': 1, 'opacity': 0.4}]}}}"));
    const View view = viewAt(film, 0.25);
    ASSERT_EQ(view.layers.size(), 1U);
    const auto style = particlesStyleOf(*view.layers[0].particles());
    EXPECT_NEAR(style.volumeOpacity(1.0), 0.1, 1e-12);
    EXPECT_NEAR(style.pointFraction(0.5), 1.0, 1e-12);
    EXPECT_NEAR(style.pointFraction(1.0), 0.75, 1e-12) << "without a volume there were all";
}

TEST(FilmKeyframes, ColourRangesFollowTheirCurves) {
    const auto rangeOf = [](const std::string& map) {
        const Film film =
            filmOf(between("{'dataset': 'a/b', 'hybrid': {" + map +
                               "'curve': [{'value': 0, 'opacity': 0}, {'value': 8, 'opacity': 1}]}}",
                           "{'dataset': 'a/b', 'hybrid': {" + map +
                               "'curve': [{'value': 4, 'opacity': 0}, {'value': 5, 'opacity': 1},"
                               "{'value': 20, 'opacity': 1}]}}"));
        const View view = viewAt(film, 0.25);
        EXPECT_EQ(view.layers.size(), 1U);
        const auto& style = *view.layers[0].hybrid();
        EXPECT_EQ(style.color_range_size(), 2);
        EXPECT_EQ(style.curve_size(), 5);
        return ValueRange{style.color_range(0), style.color_range(1)};
    };
    const ValueRange all = rangeOf("'colorMap': 'magma', ");
    EXPECT_NEAR(all.low, 1.0, 1e-12);
    EXPECT_NEAR(all.high, 11.0, 1e-12);
    // Where nobody chose colours, the curve has the part of the map from 0.4 on.
    const ValueRange readable = rangeOf("");
    EXPECT_NEAR(readable.low + 0.4 * (readable.high - readable.low), 1.0, 1e-12);
    EXPECT_NEAR(readable.high, 11.0, 1e-12);
}

TEST(FilmKeyframes, ClipsMove) {
    const Film film =
        filmOf(between("{'dataset': 'a/b', 'hybrid': {'clipPlanes': [{'normal': [1, 0, 0], 'distance': 1}],"
                       "'clipBox': {'min': [0, 0, 0], 'max': [1, 1, 1]}}}",
                       "{'dataset': 'a/b', 'hybrid': {'clipPlanes': [{'normal': [0, 2, 0], 'distance': 4}],"
                       "'clipBox': {'min': [1, 0, 0], 'max': [3, 1, 1]}}}"));
    const View view = viewAt(film, 0.5);
    ASSERT_EQ(view.layers.size(), 1U);
    const auto style = hybridStyleOf(*view.layers[0].hybrid());
    EXPECT_NEAR(style.clipPlanes[0].normal.x, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(style.clipPlanes[0].normal.y, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(style.clipPlanes[0].distance, 1.5, 1e-12);
    EXPECT_EQ(*style.clipBox, (Bounds{{0.5, 0.0, 0.0}, {2.0, 1.0, 1.0}}));
}

TEST(FilmKeyframes, StepsHoldOrBlend) {
    const auto layers = [](int step) {
        return "{'dataset': 'a/b', 'opacity': 0.5, 'particles': {}, 'step': " + std::to_string(step) +
               "}, {'dataset': 'a/b', 'ink': {}, 'step': " + std::to_string(step) + "}";
    };
    const Film held = filmOf(between(layers(2), layers(6)), 7);
    View view = viewAt(held, 0.4375);
    ASSERT_EQ(view.layers.size(), 2U);
    EXPECT_EQ(view.layers[0].step, 3U);
    EXPECT_EQ(view.layers[0].opacity, 0.5);
    EXPECT_EQ(view.layers[1].step, 3U);
    const Film blended = filmOf(between(layers(2), layers(6), ", 'betweenSteps': 'blend'"), 7);
    view = viewAt(blended, 0.4375);
    ASSERT_EQ(view.layers.size(), 2U);
    EXPECT_EQ(view.layers[0].step, 3U);
    ASSERT_TRUE(view.layers[0].towards);
    EXPECT_EQ(view.layers[0].towards->step, 4U);
    EXPECT_NEAR(view.layers[0].towards->share, 0.75, 1e-12);
    EXPECT_EQ(view.layers[0].opacity, 0.5);
    EXPECT_EQ(view.layers[1].step, 3U) << "ink is drawn of one step";
    EXPECT_FALSE(view.layers[1].towards);
    EXPECT_FALSE(viewAt(blended, 0.25).layers[0].towards) << "a step's own";
}

TEST(FilmKeyframes, ThatSayThemselvesWhereTheyAreBetweenSteps) {
    const auto layer = [](const std::string& rest) {
        return "{'dataset': 'a/b', 'particles': {}" + rest + "}";
    };
    const std::string way = ", 'step': 3, 'towards': {'step': 5, 'share': ";
    for (const std::string between_ : {"hold", "blend"}) {
        const std::string word = ", 'betweenSteps': '" + between_ + "'";
        View view = viewAt(filmOf(between(layer(way + "0.2}"), layer(way + "0.6}"), word), 7), 0.25);
        ASSERT_EQ(view.layers.size(), 1U);
        EXPECT_EQ(view.layers[0].step, 3U);
        EXPECT_EQ(view.layers[0].towards->step, 5U);
        EXPECT_NEAR(view.layers[0].towards->share, 0.3, 1e-12);
        view = viewAt(filmOf(between(layer(", 'step': 3"), layer(way + "0.6}"), word), 7), 0.25);
        ASSERT_EQ(view.layers.size(), 1U);
        EXPECT_NEAR(view.layers[0].towards->share, 0.15, 1e-12) << "it begins in its step";
        view = viewAt(filmOf(between(layer(way + "0.6}"), layer(", 'step': 1"), word), 7), 0.25);
        ASSERT_EQ(view.layers.size(), 2U) << "there is nothing in between";
        EXPECT_EQ(view.layers[0].towards, (Towards{5, 0.6}));
        EXPECT_NEAR(view.layers[0].opacity, 0.75, 1e-12);
        EXPECT_EQ(view.layers[1].step, 1U);
        EXPECT_FALSE(view.layers[1].towards);
    }
    const auto script = between(layer(way + "0.2}"), layer(way + "0.6}"));
    const auto film = Film::create(script, datasetsFor(script, 5));
    ASSERT_FALSE(film.ok());
    EXPECT_EQ(film.error().where, "keyframes[0].view.layers[0].towards.step");
}

TEST(FilmKeyframes, EasingIsOfTheWayToTheNext) {
    auto script =
        between("{'dataset': 'a/b', 'mesh': {'opacity': 0}}", "{'dataset': 'a/b', 'mesh': {'opacity': 1}}");
    const auto opacityAt = [&](double seconds) {
        return viewAt(filmOf(script), seconds).layers[0].mesh()->opacity();
    };
    script.mutable_keyframes(0)->set_easing("smooth");
    EXPECT_NEAR(opacityAt(0.25), 0.15625, 1e-12);
    EXPECT_NEAR(opacityAt(0.5), 0.5, 1e-12);
    script.mutable_keyframes(0)->set_easing("hold");
    EXPECT_EQ(opacityAt(0.999), 0.0);
    EXPECT_EQ(opacityAt(1.0), 1.0);
    script.mutable_keyframes(1)->set_easing("hold");
    EXPECT_EQ(opacityAt(1.0), 1.0);
}

TEST(FilmKeyframes, ThereIsRoomForAllLayersThatAreShownAtOnce) {
    std::string first, second;
    for (int i = 0; i < 5; ++i) {
        first += std::string(i ? ", " : "") + "{'dataset': 'a/first-" + std::to_string(i) + "', 'mesh': {}}";
        second +=
            std::string(i ? ", " : "") + "{'dataset': 'a/second-" + std::to_string(i) + "', 'mesh': {}}";
    }
    auto script = between(first, second);
    const auto film = Film::create(script, datasetsFor(script));
    ASSERT_FALSE(film.ok());
    EXPECT_EQ(film.error().where, "keyframes[1].view.layers");
    EXPECT_NE(film.error().message.find("10 layers"), std::string::npos) << film.error().message;
    EXPECT_NE(film.error().message.find("keyframes[0]"), std::string::npos);
    script.mutable_keyframes(0)->set_easing("hold");
    EXPECT_TRUE(Film::create(script, datasetsFor(script)).ok()) << "nothing is between them";
}

TEST(FilmKeyframes, AMillionFramesTakeNoTime) {
    auto script = between("{'dataset': 'a/b', 'particles': {}}", "{'dataset': 'a/b', 'particles': {}}");
    script.mutable_keyframes(1)->set_seconds(999.999);
    script.set_fps(1000.0);
    const Film film = filmOf(script);
    EXPECT_EQ(film.frameCount(), 1000000U);
    EXPECT_TRUE(parseView(film.frame(777777)).ok());
}

}  // namespace
}  // namespace mote::test
