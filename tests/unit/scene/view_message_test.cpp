// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view_message.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "protocol/base/json.h"
#include "protocol/scene/fields/resolve.h"
#include "tests/support/view_text.h"
#include "tests/unit/scene/film_scripts.h"

namespace mote::test {
namespace {

constexpr double rounding = 1e-12;

/// Makes what was rounded equal, where it differs by no more than rounding.
void snap(glm::dvec3& value, const glm::dvec3& to) {
    if (glm::length(value - to) < rounding) value = to;
}
/// Styles that are messages come back to the digit, but for normals that are made unit again.
void snap(google::protobuf::Message&, const google::protobuf::Message&) {}
void snap(proto::HybridStyle& style, const proto::HybridStyle& to) {
    ASSERT_EQ(style.clip_planes_size(), to.clip_planes_size());
    for (int i = 0; i < to.clip_planes_size(); ++i) {
        auto& plane = *style.mutable_clip_planes(i);
        const auto& other = to.clip_planes(i);
        for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(plane.normal(axis), other.normal(axis), rounding);
        EXPECT_NEAR(plane.distance(), other.distance(), rounding * std::abs(other.distance()));
        plane = other;
    }
}

void snapParts(Layer& layer, const Layer& to) {
    if (layer.highlight && to.highlight) snap(layer.highlight->color, to.highlight->color);
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
    return result;
}

TEST(ViewMessage, GivesTheViewAgain) {
    for (std::uint64_t i = 0; i < 3000; ++i) {
        const auto message = anyView(21, i);
        const View view = parseView(message).value();
        ASSERT_EQ(again(view), view) << toJson(message) << toJson(toProto(view));
    }
}

/// The style of a layer with every default that the schema says.
template <class Style>
Style filledIn(Style style) {
    fillIn(style);
    return style;
}

const google::protobuf::Message& styleOf(const proto::Layer& layer) {
    const auto& reflection = *layer.GetReflection();
    const auto* const kind = proto::Layer::descriptor()->FindOneofByName("kind");
    return reflection.GetMessage(layer, reflection.GetOneofFieldDescriptor(layer, kind));
}

/// Nothing is lost on the way through values: whatever a view says, or the schema where it does not, is in
/// the message of the parsed view.
TEST(ViewMessage, SaysAllThatTheSchemaFillsIn) {
    google::protobuf::util::MessageDifferencer difference;
    difference.set_float_comparison(google::protobuf::util::MessageDifferencer::APPROXIMATE);
    difference.set_scope(google::protobuf::util::MessageDifferencer::PARTIAL);
    // Points that give way to the volume are linked, whoever says it; nothing is quite opaque.
    difference.IgnoreField(proto::PointsStyle::descriptor()->FindFieldByName("linked"));
    difference.IgnoreField(proto::PointsStyle::descriptor()->FindFieldByName("curve"));
    difference.IgnoreField(proto::PointsStyle::descriptor()->FindFieldByName("opacity"));
    // As it is said, until the colour of the paper is known.
    difference.IgnoreField(proto::StippleStyle::descriptor()->FindFieldByName("invert"));
    std::string report;
    difference.ReportDifferencesToString(&report);
    for (std::uint64_t i = 0; i < 3000; ++i) {
        const auto said = anyView(24, i);
        const auto parsed = parseView(said).value();
        const auto written = toProto(parsed);
        for (int k = 0; k < said.layers_size(); ++k) {
            auto wanted = said.layers(k);
            if (wanted.has_particles()) *wanted.mutable_particles() = filledIn(wanted.particles());
            if (wanted.has_mesh()) *wanted.mutable_mesh() = filledIn(wanted.mesh());
            if (wanted.has_stipple()) *wanted.mutable_stipple() = filledIn(wanted.stipple());
            if (wanted.has_ink())
                *wanted.mutable_ink() = parseInkStyle(wanted.ink(), parsed.background).value();
            // Volumes have a light of their own, and planes normals of length 1.
            if (wanted.hybrid().has_light())
                *wanted.mutable_hybrid()->mutable_light() = written.layers(k).hybrid().light();
            if (wanted.has_hybrid()) wanted.mutable_hybrid()->clear_clip_planes();
            // A brush without strength is none.
            if (wanted.has_ink() && wanted.ink().ink().strength() == 0.0) wanted.mutable_ink()->clear_ink();
            report.clear();
            ASSERT_TRUE(difference.Compare(styleOf(wanted), styleOf(written.layers(k))))
                << "view " << i << ": " << report;
        }
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
    EXPECT_EQ(larger->scale, 3.0);
    const View pixels = lengthsInPixels(*larger);
    EXPECT_EQ(pixels.scale, 1.0);
    EXPECT_EQ(pixels.layers[0].particles()->points().size_pixels(), 4.5);
    EXPECT_EQ(pixels.layers[1].stipple()->spacing_pixels(), 18.0);
    EXPECT_EQ(pixels.layers[1].stipple()->dot_pixels(), 9.0);
    EXPECT_EQ(pixels.layers[1].stipple()->least_dot_pixels(), 3.0);
    EXPECT_EQ(pixels.layers[1].stipple()->jitter(), 2.0);
    const auto ink = inkStyleOf(*pixels.layers[2].ink());
    EXPECT_EQ(ink.silhouettes.width, 6.0);
    EXPECT_EQ(ink.silhouettes.crease, 50.0);
    EXPECT_EQ(ink.hatch.spacing, 15.0);
    EXPECT_EQ(ink.hatch.width, 3.75);
    EXPECT_EQ(ink.reading, 21.0);
    EXPECT_EQ(ink.waver, 1.5);
    EXPECT_EQ(larger->camera, view.camera);
}

/// Of a view of so many lines: spacing, dots, lines, hatches, reading, paths and letters, in its pixels.
std::vector<double> lengthsOf(const std::string& lines, const std::string& lengths) {
    const auto view = lengthsInPixels(viewOf("{'width': 100, 'height': " + lines + ", " + lengths));
    const auto& stipple = *view.layers[0].stipple();
    const auto ink = inkStyleOf(*view.layers[1].ink());
    return {stipple.spacing_pixels(),
            stipple.dot_pixels(),
            stipple.least_dot_pixels(),
            ink.silhouettes.width,
            ink.hatch.spacing,
            ink.hatch.width,
            ink.reading,
            view.layers[2].paths->width(),
            view.layers[3].mesh()->wire_width(),
            fontPixels(*view.annotations, view.width, view.height, view.scale)};
}

TEST(Lengths, ThatAreLeftOutGrowWithThePicture) {
    const std::string nothing =
        "'scale': 5, 'annotations': {}, 'layers': [{'stipple': {}}, {'ink': {}}, {'particles': {}, 'paths': "
        "{}},"
        "{'mesh': {}}]}";
    const std::vector<double> usual{2.6, 1.8, 1.8, 1.2, 3.5, 0.9, 6.0, 1.5, 1.0, 12.0};
    const auto times = [&](double factor) {
        std::vector<testing::Matcher<double>> grown;
        for (const double length : usual) grown.push_back(testing::DoubleEq(factor * length));
        return testing::ElementsAreArray(grown);
    };
    EXPECT_THAT(lengthsOf("720", nothing), times(1.0));
    EXPECT_THAT(lengthsOf("2160", nothing), times(3.0));
    EXPECT_THAT(lengthsOf("360", nothing), times(0.5));
}

TEST(Lengths, ThatAreSaidGoWithTheScale) {
    const std::string said =
        "'scale': 1.5, 'annotations': {'fontPoints': 6}, 'layers': [{'stipple': {'spacingPixels': 8, "
        "'dotPixels': 4}},"
        "{'ink': {'silhouettes': {'width': 2}, 'hatch': {'spacing': 6, 'width': 3}, 'reading': 10}},"
        "{'particles': {}, 'paths': {'width': 5}}, {'mesh': {}}]}";
    for (const std::string lines : {"72", "720", "7200"}) {
        const auto lengths = lengthsOf(lines, said);
        const std::vector<double> all{12.0, 6.0, 6.0, 3.0, 9.0, 4.5, 15.0, 7.5, lengths[8], 12.0};
        for (std::size_t i = 0; i < all.size(); ++i)
            EXPECT_DOUBLE_EQ(lengths[i], all[i]) << lines << ' ' << i;
    }
}

TEST(Lengths, StayWithinWhatTheyMayBe) {
    const auto least =
        lengthsOf("4",
                  "'annotations': {}, 'layers': [{'stipple': {}}, {'ink': {}}, {'particles': {}, "
                  "'paths': {}}, {'mesh': {}}]}");
    EXPECT_EQ(least[0], 0.5);
    EXPECT_EQ(least[1], 0.1);
    EXPECT_EQ(least[4], 1.0);
    auto message = toProto(viewOf("{'width': 100, 'height': 10, 'layers': [{'ink': {'reading': 13}}]}"));
    message.set_scale(20.0);
    EXPECT_EQ(parseView(message).error().toString(),
              "layers[0].ink.reading: 13 times the view's scale of 20 is more than 256 pixels");
    for (const double scale : {0.0, -1.0, 64.5, std::nan("")}) {
        message.set_scale(scale);
        EXPECT_EQ(parseView(message).error().where, "scale") << scale;
    }
}

TEST(Lengths, AreTheSameOnceTheyAreInPixels) {
    for (std::uint64_t i = 0; i < 300; ++i) {
        const View pixels = lengthsInPixels(parseView(anyView(23, i)).value());
        EXPECT_EQ(lengthsInPixels(pixels), pixels);
        EXPECT_TRUE(parseView(toProto(pixels)).ok());
    }
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
    EXPECT_EQ(
        magnified(view, 3).error().message,
        "30 times the view's scale of 3 is more than 64 pixels; the picture is made 3 times as large on "
        "each side");
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
