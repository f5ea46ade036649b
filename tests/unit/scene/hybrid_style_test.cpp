// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/hybrid_style.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "protocol/base/json.h"
#include "protocol/scene/view.h"

namespace mote {
namespace {

proto::HybridStyle messageOf(const std::string& json) {
    proto::HybridStyle message;
    const auto status = parseJson(json, message, "style");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return message;
}

TEST(HybridStyle, DefaultsAreTheDocumentedOnes) {
    const auto style = hybridStyleOf(parseHybridStyle({}).value());
    EXPECT_EQ(style.representation, HybridRepresentation::best);
    EXPECT_FALSE(style.opacity || style.colorRange || style.clipBox);
    EXPECT_TRUE(style.colors.empty() && style.clipPlanes.empty());
    EXPECT_EQ(style.colorMap.name(), "viridis");
    EXPECT_FALSE(style.ownColors);
    EXPECT_EQ(style.pointShape, PointShape::gaussian);
    EXPECT_EQ(style.pointOpacity, 1.0);
    EXPECT_EQ(style.light.ambient, 0.25);
    EXPECT_EQ(style.light.diffuse, 0.75);
    EXPECT_EQ(style.light.specular, 0.25);
    EXPECT_NEAR(glm::length(style.light.direction), 1.0, 1e-12);
}

TEST(HybridStyle, TakesAllThatIsSaid) {
    const auto style = hybridStyleOf(parseHybridStyle(messageOf(R"({"representation": "points",
        "curve": [{"value": -500, "opacity": 0}, {"value": 300, "opacity": 0.5}], "colorMap": "viridis",
        "colorRange": [-1000, 1000], "pointShape": "disc", "pointOpacity": 0.5,
        "light": {"direction": [0, 0, 3], "fixed": true, "ambient": 0.1, "diffuse": 0.5, "specular": 0.4},
        "clipPlanes": [{"normal": [0, 2, 0], "distance": 10}],
        "clipBox": {"min": [0, 0, 0], "max": [10, 20, 30]}})"))
                                         .value());
    EXPECT_EQ(style.representation, HybridRepresentation::points);
    EXPECT_EQ((*style.opacity)(-100.0), 0.25);
    EXPECT_EQ(style.colorMap.name(), "viridis");
    EXPECT_EQ(style.colorRange, (ValueRange{-1000.0, 1000.0}));
    EXPECT_EQ(style.pointShape, PointShape::disc);
    EXPECT_EQ(style.pointOpacity, 0.5);
    EXPECT_EQ(style.light.direction, glm::dvec3(0.0, 0.0, 1.0));
    EXPECT_TRUE(style.light.fixed);
    // A plane's distance counts in lengths of its normal.
    EXPECT_EQ(style.clipPlanes, (std::vector<HalfSpace>{{glm::dvec3(0.0, 1.0, 0.0), 5.0}}));
    EXPECT_EQ(style.clipBox, (Bounds{glm::dvec3(0.0), glm::dvec3(10.0, 20.0, 30.0)}));
}

TEST(HybridStyle, KnotsMayHaveColours) {
    const auto style = hybridStyleOf(parseHybridStyle(messageOf(R"({"curve":
        [{"value": 0, "opacity": 0, "color": [1, 0, 0]}, {"value": 1, "opacity": 1, "color": [1, 1, 1]}]})"))
                                         .value());
    EXPECT_EQ(style.colors, (std::vector<glm::dvec3>{{1.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}));
}

struct BadHybrid {
    const char* json;
    const char* where;
};

class BadHybridStyle : public testing::TestWithParam<BadHybrid> {};

TEST_P(BadHybridStyle, IsAnErrorThatNamesItsPath) {
    const auto style = parseHybridStyle(messageOf(GetParam().json));
    ASSERT_FALSE(style.ok());
    EXPECT_EQ(style.error().code, ErrorCode::invalidArgument);
    EXPECT_EQ(style.error().where, GetParam().where) << style.error().toString();
}

INSTANTIATE_TEST_SUITE_P(
    All, BadHybridStyle,
    testing::Values(
        BadHybrid{R"({"curve": [{"value": 1, "opacity": 1, "color": [1, 1, 1]}, {"value": 2}]})",
                  "curve[1].color"},
        BadHybrid{R"({"curve": [{"value": 1}, {"value": 2, "color": [1, 1, 1]}]})", "curve[1].color"},
        BadHybrid{R"({"curve": [{"value": 1, "color": [1, 1, 1]}], "colorMap": "viridis"})", "colorMap"},
        BadHybrid{R"({"colorRange": [1, 1]})", "colorRange"},
        BadHybrid{R"({"light": {"shadow": true}})", "light.shadow"},
        BadHybrid{R"({"clipPlanes": [{"normal": [1, 0, 0]}, {"normal": [0, 0, 0]}]})",
                  "clipPlanes[1].normal"},
        BadHybrid{R"({"clipPlanes": [{"normal": [1, 0, 0]}, {"normal": [1, 0, 0]}, {"normal": [1, 0, 0]},
                {"normal": [1, 0, 0]}, {"normal": [1, 0, 0]}, {"normal": [1, 0, 0]}, {"normal": [1, 0, 0]}]})",
                  "clipPlanes"},
        BadHybrid{R"({"clipBox": {"min": [0, 1, 0], "max": [1, 1, 1]}})", "clipBox.max[1]"}));

TEST(HybridStyle, IsALayerOfAView) {
    proto::View message;
    message.set_width(4);
    message.set_height(4);
    auto& layer = *message.add_layers();
    layer.set_dataset("data/engine");
    layer.mutable_hybrid()->set_representation("residual");
    const auto view = parseView(message);
    ASSERT_TRUE(view.ok()) << view.error().toString();
    ASSERT_NE(view->layers[0].hybrid(), nullptr);
    EXPECT_EQ(view->layers[0].hybrid()->representation(), "residual");
    layer.mutable_hybrid()->set_point_shape("star");
    EXPECT_EQ(parseView(message).error().where, "layers[0].hybrid.pointShape");
}

}  // namespace
}  // namespace mote
