// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/stipple_style.h"

#include <gtest/gtest.h>

#include "protocol/base/json.h"
#include "protocol/scene/view.h"

namespace mote {
namespace {

constexpr glm::dvec3 black(0.0), white(1.0);

StippleStyle messageOf(const char* json) {
    StippleStyle message;
    const auto status = parseJson(json, message, "style");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return message;
}

/// The first number of its colour, and where dots are dense.
std::pair<double, std::string> inkOf(const char* json, const glm::dvec3& paper) {
    const auto style = parseStippleStyle(messageOf(json), paper).value();
    EXPECT_EQ(parseStippleStyle(style, paper)->SerializeAsString(), style.SerializeAsString());
    return {style.color(0), style.dense()};
}

TEST(StippleStyle, InkIsTheOppositeOfItsPaper) {
    using Ink = std::pair<double, std::string>;
    EXPECT_EQ(inkOf("{}", black), Ink(1.0, "light"));
    EXPECT_EQ(inkOf("{}", white), Ink(0.0, "dark"));
    // Dark ink is dense where it is dark, light ink where it is light; `invert` turns both round.
    EXPECT_EQ(inkOf(R"({"color": [0.5, 0.5, 0.5]})", white), Ink(0.5, "dark"));
    EXPECT_EQ(inkOf(R"({"invert": true})", black), Ink(1.0, "dark"));
    EXPECT_EQ(inkOf(R"({"invert": true})", white), Ink(0.0, "light"));
    EXPECT_EQ(inkOf(R"({"dense": "light"})", white), Ink(0.0, "light"));
    EXPECT_EQ(inkOf(R"({"dense": "light", "invert": true})", white), Ink(0.0, "light"));
    // What knows nothing of `dense` reads the same.
    StippleStyle style = parseStippleStyle(messageOf(R"({"dense": "light"})"), white).value();
    style.clear_dense();
    EXPECT_EQ(parseStippleStyle(style, white)->dense(), "light");
}

TEST(StippleStyle, TheLeastDotIsADotWhereItIsNotSaid) {
    EXPECT_EQ(parseStippleStyle(messageOf(R"({"dotPixels": 3})"), black)->least_dot_pixels(), 3.0);
    EXPECT_EQ(
        parseStippleStyle(messageOf(R"({"dotPixels": 3, "leastDotPixels": 1})"), black)->least_dot_pixels(),
        1.0);
    EXPECT_FALSE(parseStippleStyle({}, black)->has_least_dot_pixels());
}

TEST(StippleStyle, HasAnImageOrASource) {
    EXPECT_EQ(
        parseStippleStyle(messageOf(R"({"source": "layers", "image": "a/b"})"), black).error().toString(),
        "source: is instead of an image, not beside it");
    EXPECT_EQ(parseStippleStyle(messageOf(R"({"source": "image"})"), black).error().where, "source");
}

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
    EXPECT_EQ(view->layers[0].stipple()->color(0), 0.0);
    EXPECT_TRUE(view->cameraFitted);
    message.mutable_layers(0)->mutable_stipple()->set_dot_pixels(-1.0);
    EXPECT_EQ(parseView(message).error().where, "layers[0].stipple.dotPixels");
}

}  // namespace
}  // namespace mote
