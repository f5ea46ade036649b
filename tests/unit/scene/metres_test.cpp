// SPDX-License-Identifier: GPL-3.0-or-later
//
// Layers in metres, and units of lengths.
#include "protocol/scene/space/metres.h"

#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>

#include "protocol/base/json.h"
#include "protocol/scene/space/length_unit.h"
#include "protocol/scene/view_message.h"

namespace mote {
namespace {

proto::View viewOfText(const char* json) {
    proto::View message;
    EXPECT_TRUE(parseJson(json, message, "view").ok());
    return message;
}

proto::Manifest manifestOf(const char* json) {
    proto::Manifest manifest;
    EXPECT_TRUE(parseJson(json, manifest, "manifest").ok());
    return manifest;
}

constexpr const char* plotOfSteps = R"({"kind": "particles", "particles": {
    "axes": [{"name": "z", "unit": "m", "min": 0, "max": 8}, {"name": "x", "unit": "m", "min": -1, "max": 1},
             {"name": "y", "unit": "m", "min": 2, "max": 4}],
    "steps": [{}, {"axes": [{"name": "z", "unit": "m", "min": 4, "max": 8}, {"name": "x", "unit": "m", "min": -3, "max": 1},
                            {"name": "y", "unit": "m", "min": 2, "max": 4}]}]}})";

constexpr const char* viewInMetres = R"({"width": 8, "height": 8, "space": "metres", "stretch": [1, 2, 0.5],
    "layers": [{"dataset": "data/plot", "particles": {}, "transform": [1,0,0,10, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})";

TEST(Metres, AViewIsWrittenAsItWasRead) {
    const auto view = parseView(viewOfText(viewInMetres)).value();
    ASSERT_TRUE(view.metres);
    EXPECT_EQ(view.metres->stretch, glm::dvec3(1.0, 2.0, 0.5));
    EXPECT_EQ(parseView(toProto(view)).value(), view);
    const auto plain = parseView(viewOfText(R"({"width": 8, "height": 8, "space": "metres"})")).value();
    EXPECT_EQ(toProto(plain).space(), "metres");
    EXPECT_EQ(toProto(plain).stretch_size(), 0);
    EXPECT_EQ(parseView(viewOfText(R"({"width": 8, "height": 8, "stretch": [1, 1, 1]})")).error().where,
              "stretch");
}

TEST(Metres, APlotLiesAlongTheAxesOfTheWorld) {
    const auto manifest = manifestOf(plotOfSteps);
    const auto first = placeInMetres(manifest, 0, "plot").value();
    // The plot's first axis is z: its corner lies at x, y and z of the bounds' ends.
    EXPECT_EQ(first * glm::dvec4(1, 1, 1, 1), glm::dvec4(1, 4, 8, 1));
    EXPECT_EQ(first * glm::dvec4(-1, 1, -1, 1), glm::dvec4(1, 2, 0, 1));
    EXPECT_EQ(placeInMetres(manifest, 1, "plot").value() * glm::dvec4(-1, -1, 1, 1), glm::dvec4(-3, 4, 4, 1));
    const auto place = datasetPlace(manifest);
    EXPECT_EQ(place.of(0, "plot").value(), first);
    EXPECT_EQ(place.of(1, "plot").value(), placeInMetres(manifest, 1, "plot").value());
}

TEST(Metres, ThePlaceThenTheTransformThenTheStretch) {
    const auto manifest = manifestOf(plotOfSteps);
    auto view = parseView(viewOfText(viewInMetres)).value();
    const PlaceOf placeOf = [&](const std::string& name, std::uint32_t step) {
        return placeInMetres(manifest, step, name);
    };
    ASSERT_TRUE(placeLayers(view, placeOf).ok());
    const glm::dvec4 corner(1, 1, 1, 1);
    EXPECT_EQ(view.layers[0].transform * corner, glm::dvec4(11, 8, 4, 1));
    const auto once = view;
    ASSERT_TRUE(placeLayers(view, placeOf).ok());
    EXPECT_EQ(view, once) << "placed once";
    EXPECT_TRUE(toProto(view).space().empty()) << "its matrices say it";
    // A quarter of the way to the other step's box.
    auto between = parseView(viewOfText(viewInMetres)).value();
    between.layers[0].towards = Towards{1, 0.25};
    ASSERT_TRUE(placeLayers(between, placeOf).ok());
    EXPECT_EQ(between.layers[0].transform * glm::dvec4(-1, -1, -1, 1), glm::dvec4(10 - 1.5, 4, 0.5, 1));
}

TEST(Metres, WhatHasNoPlaceIsSaid) {
    auto phase = manifestOf(plotOfSteps);
    phase.mutable_particles()->mutable_axes(1)->set_name("px");
    EXPECT_EQ(placeInMetres(phase, 0, "data/a").error().message,
              "\"data/a\" is a plot along z, px, y: only one along x, y and z has a place in metres");
    EXPECT_EQ(datasetPlace(phase).of(0, "data/a").error().message,
              placeInMetres(phase, 0, "data/a").error().message);
    auto mesh = manifestOf(R"({"kind": "mesh", "mesh": {}})");
    EXPECT_NE(placeInMetres(mesh, 0, "data/b").error().message.find("--unit"), std::string::npos);
    mesh.set_world_unit("furlong");
    EXPECT_NE(placeInMetres(mesh, 0, "data/b").error().message.find("\"furlong\""), std::string::npos);
    mesh.set_world_unit("micron");
    EXPECT_EQ(placeInMetres(mesh, 0, "data/b").value(), glm::scale(glm::dmat4(1.0), glm::dvec3(1e-6)));
    // What was damaged does no harm.
    EXPECT_FALSE(placeInMetres(manifestOf(R"({"kind": "particles", "particles": {}})"), 0, "data/c").ok());
}

TEST(LengthUnit, OneTableKnowsAllNames) {
    EXPECT_EQ(metresOf("angstrom"), 1e-10);
    EXPECT_EQ(metresOf("\xc2\xb5m"), 1e-6);
    EXPECT_EQ(metresOf("inch"), 0.0254);
    EXPECT_FALSE(metresOf(""));
    EXPECT_FALSE(metresOf("pixels"));
    EXPECT_EQ(ownName("micron"), "um");
    EXPECT_EQ(ownName("parsec"), "parsec");
    EXPECT_EQ(lengthUnitNames(), "fm, pm, angstrom, nm, um, mm, cm, dm, m, km");
}

}  // namespace
}  // namespace mote
