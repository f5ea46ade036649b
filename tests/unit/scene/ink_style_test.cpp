// SPDX-License-Identifier: GPL-3.0-or-later
//
// The style of ink: what is washed and painted is checked, filled in, and lies between two frames.
#include "protocol/scene/ink_style.h"

#include <gtest/gtest.h>

#include <string>

#include "protocol/base/json.h"
#include "protocol/scene/view.h"
#include "tests/unit/scene/film_scripts.h"

namespace mote {
namespace {

proto::InkStyle inkMessageOf(const std::string& json) {
    proto::InkStyle message;
    const auto status = parseJson(json, message, "style");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return message;
}

InkStyle inkSaid(const std::string& json) {
    return inkStyleOf(parseInkStyle(inkMessageOf(json), glm::dvec3(1.0)).value());
}

std::string inkErrorOf(const std::string& json) {
    const auto parsed = parseInkStyle(inkMessageOf(json), glm::dvec3(1.0));
    return parsed.ok() ? "" : parsed.error().toString();
}

TEST(InkStyle, AWashIsThereWhereItIsSaid) {
    EXPECT_FALSE(inkSaid("{}").wash.everywhere);
    const auto usual = inkSaid(R"({"wash": {}})").wash;
    EXPECT_TRUE(usual.everywhere);
    EXPECT_EQ(usual.tones, 3);
    EXPECT_FALSE(usual.bleed.said());
    auto painted = inkSaid(R"({"regions": [{"dabs": [0, 0, 0], "radius": 1, "fill": "wash"}]})").wash;
    EXPECT_FALSE(painted.everywhere);
    painted.everywhere = true;
    EXPECT_EQ(painted, usual) << "what is painted is washed as by default";
    EXPECT_EQ(inkSaid(R"({"wash": {"tones": 4.6}})").wash.tones, 5);
    EXPECT_EQ(inkErrorOf(R"({"wash": {"tones": 9}})"), "wash.tones: 9 is not a number from 1 to 8");
}

TEST(InkStyle, RegionsArePlacesWithARadius) {
    const auto regions = inkSaid(R"({"regions": [{"dabs": [1, 2, 3, 4, 5, 6], "radius": 2, "whole": true},
        {"dabs": [7, 8, 9], "radius": 1, "fill": "ink", "directionDegrees": 30}]})")
                             .regions;
    ASSERT_EQ(regions.size(), 2U);
    EXPECT_EQ(regions[0].dabs, (std::vector<glm::dvec3>{{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}}));
    EXPECT_TRUE(regions[0].whole);
    EXPECT_EQ(regions[0].fill, RegionFill::usual);
    EXPECT_FALSE(regions[0].direction);
    EXPECT_EQ(regions[1].radius, 1.0);
    EXPECT_EQ(regions[1].fill, RegionFill::ink);
    EXPECT_EQ(regions[1].direction, 30.0);

    const auto region = [](const std::string& said) {
        return R"({"regions": [{"dabs": [0, 0, 0], "radius": 1}, {)" + said + "}]}";
    };
    EXPECT_EQ(inkErrorOf(region(R"("radius": 1)")),
              "regions[1].dabs: three numbers a dab are needed, not 0 in all");
    EXPECT_EQ(inkErrorOf(region(R"("dabs": [1, 2, 3, 4], "radius": 1)")),
              "regions[1].dabs: three numbers a dab are needed, not 4 in all");
    EXPECT_EQ(inkErrorOf(region(R"("dabs": [1, 2, 3])")), "regions[1].radius: a radius above 0 is needed");
    EXPECT_EQ(inkErrorOf(region(R"("dabs": [1, 2, 1e31], "radius": 1)")).substr(0, 18), "regions[1].dabs[2]");
    EXPECT_EQ(inkErrorOf(region(R"("dabs": [1, 2, 3], "radius": 1, "fill": "oil")")),
              "regions[1].fill: \"oil\" is not known: there are hatch, ink, wash, none");
    proto::InkStyle many;
    for (int i = 0; i < 65; ++i) {
        auto& one = *many.add_regions();
        for (int k = 0; k < 3; ++k) one.add_dabs(0.0);
        one.set_radius(1.0);
    }
    EXPECT_EQ(parseInkStyle(many, glm::dvec3(1.0)).error().toString(), "regions: at most 64, not 65");
    many.mutable_regions()->DeleteSubrange(1, 64);
    many.mutable_regions(0)->mutable_dabs()->Resize(3 * 4096, 0.5);
    EXPECT_TRUE(parseInkStyle(many, glm::dvec3(1.0)).ok());
    many.mutable_regions(0)->mutable_dabs()->Resize(3 * 4097, 0.5);
    EXPECT_EQ(parseInkStyle(many, glm::dvec3(1.0)).error().toString(),
              "regions[0].dabs: at most 4096 dabs, not 4097");
}

View inkBetween(const std::string& first, const std::string& second, double share) {
    const auto keyframe = [](const std::string& style, int seconds) {
        return "{'seconds': " + std::to_string(seconds) +
               ", 'view': {'width': 64, 'height': 64, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]}, "
               "'layers': [{'dataset': 'a/b', 'ink': {" +
               style + "}}]}}";
    };
    const auto film = test::filmOf(
        test::scriptOf("{'keyframes': [" + keyframe(first, 0) + ", " + keyframe(second, 1) + "]}"));
    return parseView(film.at(share)).value();
}

TEST(InkStyle, WhatIsWashedAndPaintedMixes) {
    auto view = inkBetween("", "'wash': {'strength': 0.6}", 0.5);
    ASSERT_EQ(view.layers.size(), 1U) << "a wash comes by its strength";
    EXPECT_NEAR(view.layers[0].ink()->wash().strength(), 0.3, 1e-12);
    EXPECT_FALSE(inkBetween("", "'wash': {'strength': 0.6}", 0.0).layers[0].ink()->has_wash());
    const std::string region = "'regions': [{'radius': 1, 'dabs': [";
    view = inkBetween(region + "0, 0, 0, 1, 1, 1]}]", region + "2, 0, 0, 1, 1, 3]}]", 0.25);
    ASSERT_EQ(view.layers.size(), 1U);
    const auto regions = inkStyleOf(*view.layers[0].ink()).regions;
    EXPECT_EQ(regions.at(0).dabs, (std::vector<glm::dvec3>{{0.5, 0.0, 0.0}, {1.0, 1.0, 1.5}}));
    view = inkBetween(region + "0, 0, 0, 1, 1, 1]}]", region + "2, 0, 0]}]", 0.25);
    EXPECT_EQ(view.layers.size(), 2U) << "of other dabs they dissolve";
}

}  // namespace
}  // namespace mote
