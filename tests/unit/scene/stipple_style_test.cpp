// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/stipple_style.h"

#include <gtest/gtest.h>

#include <functional>
#include <glm/geometric.hpp>
#include <limits>

#include "protocol/scene/json.h"
#include "protocol/scene/view.h"

namespace mote {
namespace {

constexpr glm::dvec3 black(0.0), white(1.0);

proto::StippleStyle messageOf(const char* json) {
    proto::StippleStyle message;
    const auto status = parseJson(json, message, "style");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return message;
}

TEST(StippleStyle, DefaultsAreTheDocumentedOnes) {
    const auto style = parseStippleStyle({}, black);
    ASSERT_TRUE(style.ok());
    EXPECT_EQ(style->spacing, 5.0);
    EXPECT_EQ(style->dotSize, 2.0);
    EXPECT_EQ(style->leastDotSize, 2.0);
    EXPECT_EQ(style->opacity, 1.0);
    EXPECT_EQ(style->jitter, 0.5);
    EXPECT_EQ(style->gamma, 1.0);
    EXPECT_FALSE(style->soft || style->seeThrough || style->sourceLayers || style->light.shadow);
    EXPECT_NEAR(glm::length(style->light.direction), 1.0, 1e-12);
}

TEST(StippleStyle, InkIsTheOppositeOfItsPaper) {
    EXPECT_EQ(parseStippleStyle({}, black)->color, white);
    EXPECT_EQ(parseStippleStyle({}, white)->color, black);
    // Dark ink is dense where it is dark, light ink where it is light; `invert` turns both round.
    EXPECT_FALSE(parseStippleStyle({}, black)->denseDark);
    EXPECT_TRUE(parseStippleStyle({}, white)->denseDark);
    EXPECT_TRUE(parseStippleStyle(messageOf(R"({"invert": true})"), black)->denseDark);
    EXPECT_FALSE(parseStippleStyle(messageOf(R"({"invert": true})"), white)->denseDark);
}

TEST(StippleStyle, TakesAllThatIsSaid) {
    const auto style = parseStippleStyle(messageOf(R"({"spacingPixels": 7, "dotPixels": 3, "color": [1, 0, 0],
        "light": {"direction": [0, 2, 0], "fixed": true, "ambient": 0.1, "diffuse": 0.5, "specular": 0.4,
        "shadow": true}, "jitter": 1, "soft": true, "image": "data/photo", "gamma": 2, "opacity": 0.5,
        "seeThrough": true, "value": "depth", "colorMap": "viridis", "leastDotPixels": 1})"),
                                         black);
    ASSERT_TRUE(style.ok()) << style.error().toString();
    EXPECT_EQ(style->color, glm::dvec3(1.0, 0.0, 0.0));
    EXPECT_EQ(style->light.direction, glm::dvec3(0.0, 1.0, 0.0));
    EXPECT_TRUE(style->light.fixed && style->light.shadow && style->soft && style->seeThrough);
    EXPECT_EQ(style->image, "data/photo");
    EXPECT_EQ(style->value, DotValue::depth);
    EXPECT_EQ(style->colorMap->name(), "viridis");
    EXPECT_EQ(style->leastDotSize, 1.0);
}

struct BadStipple {
    const char* json;
    const char* where;
    friend std::ostream& operator<<(std::ostream& out, const BadStipple& bad) { return out << bad.json; }
};

class BadStippleStyle : public testing::TestWithParam<BadStipple> {};

TEST_P(BadStippleStyle, IsAnErrorThatNamesItsField) {
    const auto style = parseStippleStyle(messageOf(GetParam().json), black);
    ASSERT_FALSE(style.ok());
    EXPECT_EQ(style.error().where, GetParam().where);
}

INSTANTIATE_TEST_SUITE_P(
    All, BadStippleStyle,
    testing::Values(BadStipple{R"({"spacingPixels": 0})", "spacingPixels"},
                    BadStipple{R"({"dotPixels": "NaN"})", "dotPixels"},
                    BadStipple{R"({"leastDotPixels": 65})", "leastDotPixels"},
                    BadStipple{R"({"color": [1, 2, 0]})", "color[1]"},
                    BadStipple{R"({"opacity": 1.5})", "opacity"}, BadStipple{R"({"jitter": -1})", "jitter"},
                    BadStipple{R"({"gamma": 0})", "gamma"}, BadStipple{R"({"value": "colour"})", "value"},
                    BadStipple{R"({"colorMap": "none"})", "colorMap"},
                    BadStipple{R"({"source": "image"})", "source"},
                    BadStipple{R"({"source": "layers", "image": "a/b"})", "source"},
                    BadStipple{R"({"light": {"direction": [0, 0, 0]}})", "light.direction"},
                    BadStipple{R"({"light": {"direction": [1]}})", "light.direction"},
                    BadStipple{R"({"light": {"diffuse": 2}})", "light.diffuse"}));

TEST(StippleStyle, IsALayerOfAView) {
    proto::View message;
    ASSERT_TRUE(parseJson(R"({"width": 4, "height": 3, "background": [1, 1, 1],
                            "layers": [{"dataset": "data/teapot", "stipple": {"dotPixels": 3}}]})",
                          message, "view")
                    .ok());
    const auto view = parseView(message);
    ASSERT_TRUE(view.ok()) << view.error().toString();
    ASSERT_NE(view->layers[0].stipple(), nullptr);
    EXPECT_EQ(view->layers[0].particles(), nullptr);
    EXPECT_EQ(view->layers[0].stipple()->color, black);
    EXPECT_TRUE(view->cameraFitted);
    message.mutable_layers(0)->mutable_stipple()->set_dot_pixels(-1.0);
    EXPECT_EQ(parseView(message).error().where, "layers[0].stipple.dotPixels");
}

}  // namespace
}  // namespace mote
