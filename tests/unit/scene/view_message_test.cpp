// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view_message.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "protocol/scene/json.h"
#include "tests/support/view_text.h"
#include "tests/unit/scene/film_scripts.h"

namespace mote::test {
namespace {

constexpr double rounding = 1e-12;

/// Makes what was rounded equal, where it differs by no more than rounding.
void snap(glm::dvec3& value, const glm::dvec3& to) {
    if (glm::length(value - to) < rounding) value = to;
}
void snap(Light& light, const Light& to) {
    snap(light.direction, to.direction);
}
void snap(ParticlesStyle& style, const ParticlesStyle& to) {
    snap(style.pointColor, to.pointColor);
}
void snap(HybridStyle& style, const HybridStyle& to) {
    snap(style.light, to.light);
    ASSERT_EQ(style.colors.size(), to.colors.size());
    for (std::size_t i = 0; i < to.colors.size(); ++i) snap(style.colors[i], to.colors[i]);
    ASSERT_EQ(style.clipPlanes.size(), to.clipPlanes.size());
    for (std::size_t i = 0; i < to.clipPlanes.size(); ++i) {
        auto& plane = style.clipPlanes[i];
        const double distance = to.clipPlanes[i].distance;
        snap(plane.normal, to.clipPlanes[i].normal);
        if (std::abs(plane.distance - distance) <= rounding * std::abs(distance)) plane.distance = distance;
    }
}
void snap(StippleStyle& style, const StippleStyle& to) {
    snap(style.color, to.color);
    snap(style.light, to.light);
}
void snap(InkStyle& style, const InkStyle& to) {
    snap(style.color, to.color);
    snap(style.light, to.light);
}
void snap(MeshStyle& style, const MeshStyle& to) {
    snap(style.color, to.color);
    snap(style.light, to.light);
}

void snap(std::optional<glm::dvec3>& value, const std::optional<glm::dvec3>& to) {
    if (value && to) snap(*value, *to);
}
void snapParts(Layer& layer, const Layer& to) {
    if (layer.highlight && to.highlight) snap(layer.highlight->color, to.highlight->color);
    if (layer.paths && to.paths) snap(layer.paths->color, to.paths->color);
}

/// The view as it comes back, without rounding.
View again(const View& view) {
    const auto parsed = parseView(toProto(view));
    EXPECT_TRUE(parsed.ok()) << parsed.error().toString() << "\n" << toJson(toProto(view));
    View result = parsed.value();
    snap(result.background, view.background);
    EXPECT_EQ(result.layers.size(), view.layers.size());
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        std::visit(
            [&](auto& style) { snap(style, std::get<std::decay_t<decltype(style)>>(view.layers[i].style)); },
            result.layers[i].style);
        snapParts(result.layers[i], view.layers[i]);
    }
    if (result.annotations && view.annotations) snap(result.annotations->color, view.annotations->color);
    return result;
}

TEST(ViewMessage, GivesTheViewAgain) {
    for (std::uint64_t i = 0; i < 3000; ++i) {
        const auto message = anyView(21, i);
        const View view = parseView(message).value();
        ASSERT_EQ(again(view), view) << toJson(message) << toJson(toProto(view));
    }
}

TEST(ViewMessage, LeavesAbsentWhatOthersDecide) {
    const auto view = viewOf(
        "{'width': 8, 'height': 8, 'layers': [{'dataset': 'a/b', 'particles': {}}, {'dataset': 'a/c', "
        "'hybrid': {}},"
        "{'dataset': 'a/c', 'ink': {}}]}");
    const auto message = toProto(view);
    EXPECT_FALSE(message.has_camera());
    EXPECT_FALSE(message.layers(0).has_opacity());
    EXPECT_FALSE(message.layers(0).particles().points().has_opacity());
    EXPECT_TRUE(message.layers(0).particles().points().linked());
    EXPECT_TRUE(message.layers(1).hybrid().curve().empty());
    EXPECT_TRUE(message.layers(1).hybrid().color_range().empty());
    EXPECT_TRUE(message.layers(2).ink().curve().empty());
    EXPECT_TRUE(message.layers(2).transform().empty());
}

TEST(ViewMessage, EveryColourOfEightBitsComesBack) {
    for (int code = 0; code < 256; ++code) {
        proto::View message;
        message.set_width(1);
        message.set_height(1);
        for (int i = 0; i < 3; ++i) message.add_background(code / 255.0);
        const auto parsed = parseView(message).value();
        EXPECT_NEAR(toProto(parsed).background(0), code / 255.0, 1e-14);
    }
}

TEST(Magnified, EveryLengthInPixels) {
    const auto view = viewOf(
        "{'width': 80, 'height': 60, 'layers': [{'dataset': 'a/b', 'particles': {'points': {'sizePixels': "
        "1.5}}},"
        "{'dataset': 'a/c', 'stipple': {'spacingPixels': 6, 'dotPixels': 3, 'leastDotPixels': 1, 'jitter': "
        "2}},"
        "{'dataset': 'a/d', 'ink': {'silhouettes': {'width': 2, 'creaseDegrees': 50},"
        "'hatch': {'spacing': 5, 'width': 1.25}, 'reading': 7, 'waver': 0.5}}]}");
    const auto larger = magnified(view, 3);
    ASSERT_TRUE(larger.ok());
    EXPECT_EQ(larger->width, 240U);
    EXPECT_EQ(larger->height, 180U);
    EXPECT_EQ(larger->layers[0].particles()->pointSize, 4.5);
    EXPECT_EQ(larger->layers[1].stipple()->spacing, 18.0);
    EXPECT_EQ(larger->layers[1].stipple()->dotSize, 9.0);
    EXPECT_EQ(larger->layers[1].stipple()->leastDotSize, 3.0);
    EXPECT_EQ(larger->layers[1].stipple()->jitter, 2.0);
    const InkStyle& ink = *larger->layers[2].ink();
    EXPECT_EQ(ink.silhouettes.width, 6.0);
    EXPECT_EQ(ink.silhouettes.crease, 50.0);
    EXPECT_EQ(ink.hatch.spacing, 15.0);
    EXPECT_EQ(ink.hatch.width, 3.75);
    EXPECT_EQ(ink.reading, 21.0);
    EXPECT_EQ(ink.waver, 1.5);
    EXPECT_EQ(larger->camera, view.camera);
}

TEST(Magnified, OnceIsTheSame) {
    for (std::uint64_t i = 0; i < 300; ++i) {
        const View view = parseView(anyView(22, i)).value();
        EXPECT_EQ(magnified(view, 1).value(), view);
    }
}

TEST(Magnified, SaysWhatBecomesTooLarge) {
    auto view =
        viewOf("{'width': 5000, 'height': 10, 'layers': [{'particles': {'points': {'sizePixels': 30}}}]}");
    EXPECT_EQ(magnified(view, 4).error().where, "width");
    EXPECT_EQ(magnified(view, 3).error().where, "layers[0].particles.points.sizePixels");
    EXPECT_EQ(magnified(view, 3).error().message,
              "90 is not a number from 0.1 to 64; the picture is made 3 times as large on each side");
    EXPECT_TRUE(magnified(view, 2).ok());
    EXPECT_FALSE(magnified(view, 0).ok());
    EXPECT_FALSE(magnified(view, 4000000000U).ok());
    view.width = 4097;
    view.height = 4097;
    view.layers.clear();
    EXPECT_EQ(magnified(view, 2).error().where, "width") << "too many pixels in all";
}

}  // namespace
}  // namespace mote::test
