// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/annotate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <glm/gtc/matrix_transform.hpp>

#include "protocol/scene/srgb.h"
#include "protocol/scene/view_message.h"
#include "protocol/scene/write_fields.h"
#include "server/figures/box_edges.h"
#include "server/figures/projection.h"
#include "server/figures/quad.h"
#include "tests/support/random.h"

namespace mote::server {
namespace {

using test::Random;

std::shared_ptr<const proto::Manifest> plot() {
    auto manifest = std::make_shared<proto::Manifest>();
    manifest->set_kind("particles");
    auto& particles = *manifest->mutable_particles();
    const auto axis = [&](const char* name, const char* unit, double min, double max) {
        auto& of = *particles.add_axes();
        of.set_name(name);
        of.set_unit(unit);
        of.set_min(min);
        of.set_max(max);
    };
    axis("x", "m", -3.1e-3, 2.9e-3);
    axis("px", "eV/c", -4e5, 3.7e5);
    axis("z", "m", 12.3451, 12.3459);
    particles.set_density_min(2.0);
    particles.set_density_max(3e6);
    for (int i = 0; i < 3; ++i) {
        auto& step = *particles.add_steps();
        step.set_time(1e-9 * i);
        step.set_particles(1000000);
    }
    return manifest;
}

/// With these alone.
proto::Annotations asked(bool axes, bool colorBar, bool scaleBar, bool labels) {
    proto::Annotations annotations;
    annotations.set_axes(axes);
    annotations.set_color_bar(colorBar);
    annotations.set_scale_bar(scaleBar);
    annotations.set_labels(labels);
    annotations.set_font_points(9.0);  // said: 12 pixels in a picture of any size
    return annotations;
}

View viewOf(std::uint32_t width, std::uint32_t height) {
    View view;
    view.width = width;
    view.height = height;
    view.layers.push_back(Layer{"data/beam", 1, glm::dmat4(1.0), *parseParticlesStyle({})});
    view.annotations = asked(true, true, true, true);
    return view;
}

std::vector<LayerFacts> factsOf(const View& view) {
    return {{plot(), particlesStyleOf(*view.layers[0].particles()).transfer(), {}, 1234, 99}};
}

std::vector<TextMark> textsOf(const Marks& marks) {
    std::vector<TextMark> texts;
    for (const auto& mark : marks) {
        if (const auto* text = std::get_if<TextMark>(&mark)) texts.push_back(*text);
    }
    return texts;
}

std::set<std::string> wordsOf(const Marks& marks) {
    std::set<std::string> words;
    for (const auto& text : textsOf(marks)) words.insert(toPlain(text.text));
    return words;
}

Camera anyCamera(Random& random) {
    Camera camera;
    const glm::dvec3 target(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    camera.target = random.chance(0.5) ? glm::dvec3(0.0) : target;
    camera.eye = camera.target + random.magnitude(-4, 5) * random.direction();
    if (random.chance(0.2)) camera.eye = camera.target + glm::dvec3(0.0, 0.0, random.magnitude(-2, 4));
    camera.up = random.chance(0.3) ? glm::dvec3(0.0, 1.0, 0.0) : random.direction();
    if (random.chance(0.4)) camera.orthographicHeight = random.magnitude(-4, 5);
    camera.fovYDegrees = random.between(1.0, 150.0);
    return camera;
}

TEST(Annotate, noLabelLeavesThePictureOrLiesOverAnother) {
    Random random(20261124);
    const Typeface typeface;
    std::size_t most = 0;
    for (int trial = 0; trial < 700; ++trial) {
        SCOPED_TRACE(trial);
        View view = viewOf(64 + static_cast<std::uint32_t>(random.below(1900)),
                           64 + static_cast<std::uint32_t>(random.below(1000)));
        const Camera camera = anyCamera(random);
        if (!parseCamera(toProto(camera)).ok()) continue;
        view.camera = camera;
        view.annotations->set_font_points(random.between(4.0, 30.0));
        if (random.chance(0.3)) view.layers[0].transform[0] *= -random.magnitude(-3, 3);
        if (random.chance(0.3)) view.annotations->set_title("A title <&> \u05d0 " + std::string(200, 'w'));
        const auto texts = textsOf(annotate(view, factsOf(view)));
        most = std::max(most, texts.size());
        const Box picture{{0.0, 0.0}, {view.width, view.height}};
        for (std::size_t i = 0; i < texts.size(); ++i) {
            const Quad quad = quadOf(texts[i], typeface);
            EXPECT_TRUE(picture.holds(boxAround(quad))) << toPlain(texts[i].text);
            for (std::size_t k = 0; k < i; ++k)
                EXPECT_FALSE(meet(quad, quadOf(texts[k], typeface)))
                    << toPlain(texts[i].text) << " over " << toPlain(texts[k].text);
        }
    }
    EXPECT_GT(most, 20u);
}

/// Labels of outermost edges lie outside of what the box covers.
TEST(Annotate, labelsOfAPlotInFullViewStandBesideItAndTellEachAxis) {
    Random random(5);
    const Typeface typeface;
    for (int trial = 0; trial < 200; ++trial) {
        SCOPED_TRACE(trial);
        View view = viewOf(1280, 720);
        *view.annotations = asked(true, false, false, false);
        const glm::dvec3 direction = random.direction();
        // Not along an axis or nearly so: there an axis has no length and no labels.
        if (std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)}) > 0.9) continue;
        view.camera.eye = 9.0 * direction;
        view.camera.up = std::abs(direction.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
        const auto marks = annotate(view, factsOf(view));
        int titles = 0;
        for (const auto& words : wordsOf(marks)) titles += words.find('(') != std::string::npos ? 1 : 0;
        EXPECT_EQ(titles, 3);
        const Projection projection(view);
        const auto corner = [&](int i) {
            const glm::dvec4 at(2.0 * (i & 1) - 1.0, (i & 2) - 1.0, 0.5 * (i & 4) - 1.0, 1.0);
            return projection.pixel(glm::dvec3(projection.worldToEye() * at));
        };
        for (const auto& text : textsOf(marks)) {
            const Quad quad = quadOf(text, typeface);
            for (int a = 0; a < 8; ++a) {
                for (const int b : {a ^ 1, a ^ 2, a ^ 4}) {
                    const glm::dvec2 from = corner(a), to = corner(b);
                    EXPECT_FALSE(meet(quad, Quad{from, to, to + 1e-3, from + 1e-3})) << toPlain(text.text);
                }
            }
        }
    }
}

TEST(Annotate, aPlotSeenAlongAnAxisIsAnOrdinaryFrame) {
    View view = viewOf(800, 800);
    *view.annotations = asked(true, false, false, false);
    view.camera.orthographicHeight = 2.8;
    const auto marks = annotate(view, factsOf(view));
    int lines = 0;
    for (const auto& mark : marks) {
        const auto* line = std::get_if<LineMark>(&mark);
        if (line == nullptr) continue;
        const glm::dvec2 way = line->points[1] - line->points[0];
        EXPECT_TRUE(std::abs(way.x) < 1e-6 || std::abs(way.y) < 1e-6);
        if (std::abs(way.x) + std::abs(way.y) > 500.0) ++lines;
    }
    EXPECT_EQ(lines, 4);
    const auto words = wordsOf(marks);
    EXPECT_EQ(words.count("x (mm)"), 1u);
    EXPECT_EQ(words.count("p_x (keV/c)"), 1u);
    EXPECT_EQ(words.count("0"), 1u + 0u) << "of both axes";
    for (const auto& text : textsOf(marks)) {
        if (toPlain(text.text) != "x (mm)") continue;
        EXPECT_GT(text.place.y, 400.0 + 800.0 / 2.8);
    }
}

/// Where a tick of an axis is drawn, the camera shows that place of the box.
TEST(Annotate, ticksStandWhereTheirValuesAreSeen) {
    Random random(9);
    for (int trial = 0; trial < 100; ++trial) {
        View view = viewOf(1000, 1000);
        *view.annotations = asked(true, false, false, false);
        view.camera.eye = 6.0 * random.direction();
        view.camera.up = glm::dvec3(0.3, 1.0, 0.2);
        if (trial % 2 == 0) view.camera.orthographicHeight = 4.0;
        const Projection projection(view);
        const auto box = boxInPicture(projection.worldToEye(), projection, {{0, 0}, {1000, 1000}});
        for (const auto& mark : annotate(view, factsOf(view))) {
            const auto* line = std::get_if<LineMark>(&mark);
            if (line == nullptr || glm::distance(line->points[0], line->points[1]) > 10.0) continue;
            double nearest = 1e9;
            for (const auto& edge : box.edges) {
                const glm::dvec2 low = projection.pixel(edge.low), way = projection.pixel(edge.high) - low;
                const double share =
                    std::clamp(glm::dot(line->points[0] - low, way) / glm::dot(way, way), 0.0, 1.0);
                nearest = std::min(nearest, glm::distance(line->points[0], low + share * way));
            }
            EXPECT_LT(nearest, 1e-6);
        }
    }
}

TEST(Annotate, wordsTellDatasetStepTimeAndCounts) {
    View view = viewOf(1280, 720);
    view.camera.eye = {3, 3, 8};
    const auto words = wordsOf(annotate(view, factsOf(view)));
    EXPECT_EQ(words.count("data/beam   step 1 of 2   t = 1\u2009ns"), 1u);
    EXPECT_EQ(words.count(
                  "1234 of 1\u2009000\u2009000 particles   99 of 1\u2009000\u2009000 particles highlighted"),
              1u);
    // The weight over 6e-3 m, 7.7e5 eV/c and 8e-4 m, in mm, keV/c and m: 8 decades from 540.
    EXPECT_EQ(words.count("density (mm^\u22121\u2009m^\u22121\u2009(keV/c)^\u22121)"), 1u);
    EXPECT_EQ(words.count("10^5"), 1u);
}

TEST(Annotate, wordsTellHowManyParticlesOfWhichSpecies) {
    View view = viewOf(1280, 720);
    auto facts = factsOf(view);
    auto manifest = *facts[0].manifest;
    manifest.mutable_particles()->set_species("H-");
    facts[0].manifest = std::make_shared<proto::Manifest>(manifest);
    EXPECT_EQ(wordsOf(annotate(view, facts))
                  .count("1234 of 1\u2009000\u2009000 particles   99 of 1\u2009000\u2009000 particles "
                         "highlighted   H-"),
              1u);
    facts[0].chosen.reset();
    facts[0].highlighted.reset();
    // A run of one step has a time, too.
    manifest.mutable_particles()->mutable_steps()->DeleteSubrange(0, 1);
    manifest.mutable_particles()->mutable_steps()->DeleteSubrange(1, 1);
    view.layers[0].step = 0;
    facts[0].manifest = std::make_shared<proto::Manifest>(manifest);
    const auto words = wordsOf(annotate(view, facts));
    EXPECT_EQ(words.count("1\u2009000\u2009000 particles   H-"), 1u);
    EXPECT_EQ(words.count("data/beam   t = 1\u2009ns"), 1u);
}

TEST(Annotate, wordsTellBothStepsThatALayerIsBetween) {
    View view = viewOf(1280, 720);
    view.layers[0].towards = Towards{2, 0.25};
    const std::string words = "data/beam   step 1 to 2 (25%, dissolving) of 2   t = 1.25\u2009ns";
    EXPECT_EQ(wordsOf(annotate(view, factsOf(view))).count(words), 1u) << "nobody can follow its particles";
    view.layers[0].step = 2;
    view.layers[0].towards = Towards{1, 0.75};
    EXPECT_EQ(wordsOf(annotate(view, factsOf(view))).count(words), 1u) << "the same from its other end";
}

TEST(Annotate, whatIsNotAskedForOrNotKnownIsNotSaid) {
    View view = viewOf(1280, 720);
    view.annotations.emplace();
    EXPECT_TRUE(annotate(view, factsOf(view)).empty());
    view.annotations = asked(true, true, true, true);
    EXPECT_TRUE(annotate(view, std::vector<LayerFacts>(1)).empty());
    view.layers[0].opacity = 0.0;
    EXPECT_TRUE(annotate(view, factsOf(view)).empty());
    view.layers.clear();
    EXPECT_TRUE(annotate(view, {}).empty());
}

TEST(Annotate, colorsStandOutFromTheBackground) {
    for (const double background : {0.0, 1.0}) {
        View view = viewOf(640, 480);
        view.background = glm::dvec3(background);
        view.camera.eye = {3, 3, 8};
        for (const auto& text : textsOf(annotate(view, factsOf(view))))
            EXPECT_LT(glm::distance(text.ink.color, glm::dvec3(1.0 - background)), 1e-9);
        writeColor({1.0, 0.0, 0.0}, view.annotations->mutable_color());
        for (const auto& text : textsOf(annotate(view, factsOf(view))))
            EXPECT_LT(glm::distance(text.ink.color, glm::dvec3(1.0, 0.0, 0.0)), 1e-9);
    }
}

/// Where there is no volume, what has a density is points, and these have a colour of their own.
TEST(Annotate, aDensityBarHasTheColorsThatAreDrawn) {
    View view = viewOf(1280, 720);
    view.annotations = asked(false, true, false, false);
    auto facts = factsOf(view);
    facts[0].transfer->opacity = *Curve::create({{0.5, 0.0}, {0.5, 0.2}, {1.0, 0.2}});
    facts[0].transfer->colorRange = {0.0, 1.0};
    facts[0].points = glm::dvec3(0.0, 0.0, 1.0);
    const auto color = [&](double share) {
        std::array<int, 3> found{-1, -1, -1};
        for (const auto& mark : annotate(view, facts)) {
            const auto* const bar = std::get_if<ImageMark>(&mark);
            if (bar == nullptr) continue;
            const auto at = 4 * static_cast<std::size_t>((1.0 - share) * bar->height);
            found = {bar->rgba[at], bar->rgba[at + 1], bar->rgba[at + 2]};
        }
        return found;
    };
    EXPECT_EQ(color(0.1), (std::array<int, 3>{0, 0, 255}));
    EXPECT_EQ(color(0.45), (std::array<int, 3>{0, 0, 255}));
    const glm::dvec3 dense = linearToSrgb(facts[0].transfer->color(1.0)) * 255.0;
    EXPECT_NEAR(color(0.999)[0], dense.x, 4.0);
    EXPECT_NEAR(color(0.999)[2], dense.z, 4.0);
    facts[0].points.reset();
    const glm::dvec3 thin = linearToSrgb(facts[0].transfer->color(0.1)) * 255.0;
    EXPECT_NEAR(color(0.1)[0], thin.x, 4.0);
    EXPECT_NEAR(color(0.1)[2], thin.z, 4.0);
}

/// Colours begin below the least value, so that what is thin can be read; values do not.
TEST(Annotate, aBarOfValuesHasThoseThatThereAre) {
    auto manifest = std::make_shared<proto::Manifest>();
    manifest->mutable_hybrid()->set_value_min(0.0);
    manifest->mutable_hybrid()->set_value_max(255.0);
    View view = viewOf(1280, 720);
    view.annotations = asked(false, true, false, false);
    view.layers[0].style = *parseHybridStyle({});
    LayerFacts facts{manifest, particlesStyleOf(*parseParticlesStyle({})).transfer()};
    facts.transfer->colorRange = {-60.0, 255.0};
    const auto begin = [&](double value) {
        facts.transfer->opacity = *Curve::create({{value, 0.1}, {255.0, 1.0}}, -100.0, 300.0);
    };
    begin(-10.0);
    EXPECT_EQ(wordsOf(annotate(view, {facts})),
              (std::set<std::string>{"0", "50", "100", "150", "200", "250", "value"}));
    begin(60.0);
    EXPECT_EQ(wordsOf(annotate(view, {facts})), (std::set<std::string>{"100", "150", "200", "250", "value"}))
        << "what the curve leaves out has no colour";
    proto::HybridStyle said;
    said.add_color_range(-60.0);
    said.add_color_range(255.0);
    view.layers[0].style = *parseHybridStyle(said);
    EXPECT_EQ(wordsOf(annotate(view, {facts})).count("\u221250"), 1u);
}

/// What the one scale bar of a picture says over what it is, in metres a pixel.
double saidMetres(const std::vector<Mark>& marks) {
    const std::string text = toPlain(textsOf(marks).at(0).text);
    const auto unit = text.substr(text.find("\u2009") + 3);
    static const std::map<std::string, double> units{
        {"fm", 1e-15}, {"pm", 1e-12}, {"nm", 1e-9}, {"\u00b5m", 1e-6}, {"mm", 1e-3}, {"m", 1.0}, {"km", 1e3}};
    const auto& bar = std::get<LineMark>(marks[0]);
    return std::stod(text) * units.at(unit) / (bar.points[1].x - bar.points[0].x);
}

TEST(Annotate, scaleBarsOfMeshesAndOfMetres) {
    auto mesh = std::make_shared<proto::Manifest>();
    mesh->mutable_mesh();
    mesh->set_world_unit("angstrom");
    View view = viewOf(1000, 500);
    *view.annotations = asked(false, false, true, false);
    view.camera.orthographicHeight = 30.0;
    const double worldOfPixel = 30.0 / 500.0;
    EXPECT_NEAR(saidMetres(annotate(view, {{mesh}})), worldOfPixel * 1e-10, 1e-6 * worldOfPixel * 1e-10);
    // In metres it is the world's, whatever the layers are.
    view.metres = Metres{glm::dvec3(100.0), true};
    view.layers[0].transform = glm::scale(glm::dmat4(1.0), glm::dvec3(1e-8, 1e-8, 2e-8));
    EXPECT_NEAR(saidMetres(annotate(view, {{mesh}})), worldOfPixel / 100.0, 1e-6 * worldOfPixel / 100.0);
    view.metres->stretch.z = 99.0;
    EXPECT_TRUE(annotate(view, {{mesh}}).empty());
}

TEST(Annotate, theScaleBarIsAsLongAsItSays) {
    auto manifest = std::make_shared<proto::Manifest>();
    manifest->mutable_hybrid()->set_world_unit("mm");
    Random random(4);
    for (int trial = 0; trial < 50; ++trial) {
        View view = viewOf(1000, 500);
        *view.annotations = asked(false, false, true, false);
        view.layers[0].style = *parseHybridStyle({});
        view.camera.orthographicHeight = random.magnitude(-20, 20);
        const double factor = trial % 2 == 0 ? 1.0 : random.magnitude(-6, 6);
        view.layers[0].transform =
            glm::scale(glm::rotate(glm::dmat4(1.0), 0.1 * trial, glm::dvec3(1, 2, 3)), glm::dvec3(factor));
        const auto marks = annotate(view, {{manifest}});
        ASSERT_EQ(textsOf(marks).size(), 1u);
        const auto& bar = std::get<LineMark>(marks[0]);
        const double pixels = bar.points[1].x - bar.points[0].x;
        EXPECT_GT(pixels, 90.0);  // at most 2.5 times less than a quarter
        EXPECT_LE(pixels, 250.0 + 1e-6);
        const double expected = *view.camera.orthographicHeight / 500.0 / factor * 1e-3;
        EXPECT_NEAR(saidMetres(marks), expected, 1e-6 * expected);
        // Where directions have lengths of their own, none is true.
        view.layers[0].transform = glm::scale(view.layers[0].transform, glm::dvec3(1.0, 1.0, 1.1));
        EXPECT_TRUE(annotate(view, {{manifest}}).empty());
    }
}

/// Labels as large as in a column of print leave no axis but to its inner edges, where the plot is.
TEST(Annotate, axesInPrintAreLabelledOutside) {
    for (const double points : {9.0, 14.0, 20.0, 28.0}) {
        View view = viewOf(1016, 760);
        view.annotations = asked(true, false, false, false);
        view.annotations->set_font_points(points);
        view.cameraFitted = true;
        fitLayers(view, std::vector<std::optional<LayerBox>>{LayerBox{}});
        const Projection projection(view);
        const auto box = boxInPicture(projection.worldToEye(), projection, {{0, 0}, {1016, 760}});
        const auto marks = annotate(view, factsOf(view));
        for (const char* const title : {"x (mm)", "p_x (keV/c)"}) EXPECT_EQ(wordsOf(marks).count(title), 1u);
        for (const auto& text : textsOf(marks)) {
            const glm::dvec2 at = boxAround(quadOf(text, Typeface())).center();
            const auto outside = [&](const BoxEdge& edge) {
                const glm::dvec2 low = projection.pixel(edge.low), way = projection.pixel(edge.high) - low;
                const glm::dvec2 out(way.y, -way.x);
                return edge.kind == BoxEdge::Kind::outline &&
                       glm::dot(out, at - low) * glm::dot(out, box.middle - low) < 0.0;
            };
            EXPECT_TRUE(std::any_of(box.edges.begin(), box.edges.end(), outside)) << toPlain(text.text);
        }
    }
}

TEST(FitLayers, leavesRoomForWhatIsThereAlone) {
    View view = viewOf(1016, 760);
    view.annotations->set_font_points(28.0);
    EXPECT_GT(fitMargin(view).y, 0.1);
    EXPECT_GT(fitMargin(view).x, 0.2);
    view.layers[0].style = *parseHybridStyle({});
    EXPECT_EQ(fitMargin(view).y, CameraFit::usualMargin) << "a volume has no axes";
    EXPECT_GT(fitMargin(view).x, 0.2) << "but a bar";
    view.layers[0].style = *parseInkStyle({}, glm::dvec3(1.0));
    EXPECT_EQ(fitMargin(view), glm::dvec2(CameraFit::usualMargin));
}

TEST(FitLayers, leavesRoomForLabels) {
    View view = viewOf(1280, 720);
    view.cameraFitted = true;
    const std::vector<std::optional<LayerBox>> boxes{LayerBox{}};
    fitLayers(view, boxes);
    const double with = glm::distance(view.camera.eye, view.camera.target);
    EXPECT_EQ(wordsOf(annotate(view, factsOf(view))).count("x (mm)"), 1u);
    view.annotations.reset();
    fitLayers(view, boxes);
    EXPECT_LT(glm::distance(view.camera.eye, view.camera.target), with);
}

}  // namespace
}  // namespace mote::server
