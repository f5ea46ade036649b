// SPDX-License-Identifier: GPL-3.0-or-later
//
// The generator of views: what it says of itself, that the same number gives the same view, and that its
// views reach the ends of the schema.
#include <gtest/gtest.h>

#include <set>

#include "protocol/base/json.h"
#include "protocol/scene/view.h"
#include "tests/views/view_data.h"
#include "tests/views/view_generator.h"

namespace mote::test {
namespace {

constexpr std::uint64_t views = 1000;

TEST(Generator, GivesTheSameViewAgain) {
    for (std::uint64_t i = 0; i < 50; ++i) {
        const auto view = generatedView(3, i);
        EXPECT_EQ(toJson(view), toJson(generatedView(3, i)));
        EXPECT_NE(toJson(view), toJson(generatedView(4, i)));
    }
}

TEST(Generator, ViewsAreTheSameAfterAFile) {
    for (std::uint64_t i = 0; i < 200; ++i) {
        const auto view = generatedView(3, i);
        proto::View again;
        ASSERT_TRUE(parseJson(toJson(view), again, "view").ok());
        EXPECT_EQ(view.SerializeAsString(), again.SerializeAsString());
    }
}

/// How much there is of which kind of layer.
std::string fadedOf(const proto::Layer& layer) {
    const std::string kind = std::to_string(layer.kind_case());
    if (layer.opacity() == 0.0) return "nothing of " + kind;
    return (layer.opacity() == 1.0 ? "all of " : "some of ") + kind;
}

/// What some view has, by name.
std::set<std::string> featuresOf(const proto::View& view) {
    std::set<std::string> has;
    has.insert("layers " + std::to_string(view.layers_size()));
    if (view.width() == 1 && view.height() == 1) has.insert("one pixel");
    if (!view.has_camera()) has.insert("fitted");
    if (view.camera().fov_y_degrees() == 0.1) has.insert("telescope");
    if (view.camera().fov_y_degrees() == 179.0) has.insert("wide angle");
    if (view.camera().has_orthographic_height()) has.insert("orthographic");
    for (const auto& layer : view.layers()) {
        has.insert("step " + std::to_string(layer.step()));
        has.insert("kind " + std::to_string(layer.kind_case()));
        if (layer.transform().empty()) has.insert("identity");
        if (layer.hidden()) has.insert("hidden");
        if (!layer.name().empty()) has.insert("named");
        if (!layer.has_opacity()) has.insert("all of a layer");
        if (layer.has_opacity()) has.insert(fadedOf(layer));
        if (layer.has_towards()) has.insert("towards of " + std::to_string(layer.kind_case()));
        if (layer.has_hybrid()) {
            has.insert("representation " + layer.hybrid().representation());
            has.insert("shape " + layer.hybrid().point_shape());
            has.insert("planes " + std::to_string(layer.hybrid().clip_planes_size()));
            if (layer.hybrid().has_clip_box()) has.insert("box");
        }
        if (layer.particles().points().opacity() == 1.0) has.insert("opaque points");
        if (layer.particles().points().size_pixels() == 64.0) has.insert("large points");
        if (layer.particles().volume().curve_size() == 256) has.insert("256 knots");
    }
    return has;
}

TEST(Generator, ReachesTheEndsOfTheSchema) {
    std::set<std::string> all;
    for (std::uint64_t i = 0; i < views; ++i) all.merge(featuresOf(generatedView(5, i)));
    for (const char* const feature : {"layers 0",
                                      "layers 1",
                                      "layers 8",
                                      "one pixel",
                                      "hidden",
                                      "named",
                                      "fitted",
                                      "telescope",
                                      "wide angle",
                                      "orthographic",
                                      "step 0",
                                      "step 2",
                                      "kind 4",
                                      "kind 5",
                                      "kind 6",
                                      "kind 9",
                                      "identity",
                                      "all of a layer",
                                      "nothing of 4",
                                      "nothing of 5",
                                      "nothing of 6",
                                      "nothing of 7",
                                      "nothing of 8",
                                      "some of 4",
                                      "some of 5",
                                      "some of 6",
                                      "some of 7",
                                      "some of 8",
                                      "some of 9",
                                      "all of 4",
                                      "all of 5",
                                      "towards of 4",
                                      "towards of 5",
                                      "representation points",
                                      "representation residual",
                                      "representation volume",
                                      "representation ",
                                      "shape disc",
                                      "shape gaussian",
                                      "shape square",
                                      "planes 6",
                                      "box",
                                      "opaque points",
                                      "large points",
                                      "256 knots"}) {
        EXPECT_TRUE(all.contains(feature)) << feature;
    }
}

TEST(Generator, ViewsHaveTheirData) {
    ViewData data;
    for (std::uint64_t i = 0; i < views; ++i) {
        const auto scene = data.scene(generatedView(5, i));
        ASSERT_TRUE(scene.ok()) << i << ": " << scene.error().toString();
    }
}

TEST(Generator, DataThatAreNotThereAreNotFound) {
    auto view = generatedView(5, 0);
    ViewData data;
    for (const char* const name :
         {"", "views/", "views/beam", "views/-1", "views/beam-12", "views/beam-1x"}) {
        view.clear_layers();
        view.add_layers()->set_dataset(name);
        view.mutable_layers(0)->mutable_particles();
        EXPECT_FALSE(data.scene(view).ok()) << name;
    }
}

}  // namespace
}  // namespace mote::test
