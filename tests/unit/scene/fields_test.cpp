// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the schema says of fields holds together, and messages are checked and filled in by it.
#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <vector>

#include "protocol/base/json.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"

namespace mote {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using proto::Facts;

constexpr double infinity = std::numeric_limits<double>::infinity();

void collectTypes(const Descriptor& type, std::set<const Descriptor*>& types) {
    if (type.file() != proto::View::descriptor()->file() || !types.insert(&type).second) return;
    for (int i = 0; i < type.field_count(); ++i) {
        if (type.field(i)->message_type() != nullptr) collectTypes(*type.field(i)->message_type(), types);
    }
}

/// All types of messages within a message.
std::set<const Descriptor*> typesWithin(const Descriptor& type) {
    std::set<const Descriptor*> types;
    collectTypes(type, types);
    return types;
}

/// All types of what clients ask for: views and jobs.
std::set<const Descriptor*> askedTypes() {
    auto types = typesWithin(*proto::View::descriptor());
    types.merge(typesWithin(*proto::JobRequest::descriptor()));
    return types;
}

std::unique_ptr<Message> emptyOf(const Descriptor& type) {
    return std::unique_ptr<Message>(
        google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type)->New());
}

/// All numbers of a field are one; a list of any number has it once.
void setAll(Message& message, const FieldDescriptor& field, double value) {
    const auto& reflection = *message.GetReflection();
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_UINT32)
        return reflection.SetUInt32(&message, &field, static_cast<std::uint32_t>(value));
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_UINT64)
        return reflection.SetUInt64(&message, &field, static_cast<std::uint64_t>(value));
    if (!field.is_repeated()) return reflection.SetDouble(&message, &field, value);
    reflection.ClearField(&message, &field);
    for (int i = 0; i < std::max(countOf(field), 1); ++i) reflection.AddDouble(&message, &field, value);
}

/// With all that must be said.
std::unique_ptr<Message> legalOf(const Descriptor& type) {
    auto message = emptyOf(type);
    for (int i = 0; i < type.field_count(); ++i) {
        const auto& field = *type.field(i);
        const auto ends = endsOf(field);
        if (factsOf(field).needed()) setAll(*message, field, 0.5);
        // A whole number that is always there.
        if (ends && !field.is_repeated() && !field.has_presence()) setAll(*message, field, ends->least);
    }
    return message;
}

TEST(Facts, OfAFieldHoldTogether) {
    for (const auto* type : askedTypes()) {
        for (int i = 0; i < type->field_count(); ++i) {
            const auto& field = *type->field(i);
            SCOPED_TRACE(field.full_name());
            const auto& facts = factsOf(field);
            const auto ends = endsOf(field);
            for (const double value : facts.default_()) {
                EXPECT_TRUE(!ends || (value >= ends->least && value <= ends->greatest));
            }
            EXPECT_EQ(facts.has_from(), facts.has_to());
            EXPECT_TRUE(facts.as() != Facts::LENGTH || (ends && field.has_presence()));
            if (facts.has_slider()) {
                EXPECT_TRUE(ends && facts.slider().from() >= ends->least);
                EXPECT_LE(facts.slider().to(), ends->greatest);
                EXPECT_LT(facts.slider().from(), facts.slider().to());
            }
            const auto& word = facts.default_word();
            EXPECT_TRUE(facts.as() != Facts::COLOR_MAP || word.empty() || ColorMap::find(word).ok());
            EXPECT_TRUE(facts.label().empty() || !facts.help().empty());
        }
    }
}

/// But for densities, which are ordered and above 0.
TEST(Facts, EveryNumberOfAStyleHasEnds) {
    const auto& kinds = *proto::Layer::descriptor()->FindOneofByName("kind");
    for (int i = 0; i < kinds.field_count(); ++i) {
        for (const auto* type : typesWithin(*kinds.field(i)->message_type())) {
            for (int k = 0; k < type->field_count(); ++k) {
                const auto& field = *type->field(k);
                if (field.cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE) continue;
                EXPECT_TRUE(endsOf(field) || field.name() == "density_range") << field.full_name();
            }
        }
    }
}

void expectTaken(const FieldDescriptor& field, double value) {
    const auto message = legalOf(*field.containing_type());
    setAll(*message, field, value);
    fillIn(*message);
    const auto status = checkFields(*message);
    EXPECT_TRUE(status.ok()) << status.error().toString();
}

void expectRefused(const FieldDescriptor& field, double value) {
    const auto message = legalOf(*field.containing_type());
    setAll(*message, field, value);
    fillIn(*message);
    const auto status = checkFields(*message);
    ASSERT_FALSE(status.ok()) << field.full_name() << " = " << value;
    EXPECT_EQ(status.error().code, ErrorCode::invalidArgument);
    EXPECT_EQ(status.error().where, field.json_name() + (field.is_repeated() ? "[0]" : ""));
    EXPECT_NE(status.error().message.find("is not a number from"), std::string::npos);
}

/// What a field of a number may not be, beside its ends.
std::vector<double> beyond(const FieldDescriptor& field, const Ends& ends) {
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE)
        return {std::nextafter(ends.least, -infinity), std::nextafter(ends.greatest, infinity), infinity,
                -infinity, std::numeric_limits<double>::quiet_NaN()};
    std::vector<double> wrong{ends.greatest + 1.0};
    if (ends.least > 0.0) wrong.push_back(ends.least - 1.0);
    return wrong;
}

TEST(Resolve, TakesWhatLiesAtItsEndsAndNothingBeyond) {
    int fields = 0;
    for (const auto* type : askedTypes()) {
        for (int i = 0; i < type->field_count(); ++i) {
            const auto& field = *type->field(i);
            const auto ends = endsOf(field);
            if (!ends) continue;
            SCOPED_TRACE(field.full_name());
            ++fields;
            expectTaken(field, ends->greatest);
            if (factsOf(field).as() != Facts::DIRECTION) expectTaken(field, ends->least);
            for (const double value : beyond(field, *ends)) expectRefused(field, value);
        }
    }
    EXPECT_GT(fields, 50);
}

TEST(Facts, HelpNamesTheDefault) {
    const auto help = [](const Descriptor& type, const char* name) {
        return helpOf(*type.FindFieldByName(name));
    };
    const auto& particles = *proto::ParticlesJob::descriptor();
    EXPECT_EQ(help(particles, "volume_level"), "The volume has 2^LEVEL cells a side; default 6");
    EXPECT_EQ(help(particles, "lost"), "Particles that the source marks as lost; default without");
    EXPECT_EQ(help(*proto::SynthBeamJob::descriptor(), "particles"), "Macro-particles; default 1000000");
    EXPECT_EQ(help(*proto::MeshJob::descriptor(), "isovalue"),
              "The surface on which a volume has this value");
}

TEST(Resolve, FillsInWholeNumbers) {
    proto::ParticlesJob job;
    fillIn(job);
    EXPECT_EQ(job.volume_level(), 6U);
    EXPECT_EQ(job.leaf_capacity(), 32U);
    job.set_max_level(3);
    EXPECT_EQ(numberOf(job, proto::ParticlesJob::kMaxLevelFieldNumber), 3.0);
}

template <class Message>
Message read(const char* json) {
    Message message;
    const auto status = parseJson(json, message, "message");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return message;
}

template <class Message>
std::string errorOf(const char* json) {
    const auto made = resolved(read<Message>(json));
    return made.ok() ? "none" : made.error().toString();
}

template <class Message>
void expectResolved(const char* json, const char* wanted) {
    const auto made = resolved(read<Message>(json));
    ASSERT_TRUE(made.ok()) << made.error().toString();
    google::protobuf::util::MessageDifferencer difference;
    difference.set_float_comparison(google::protobuf::util::MessageDifferencer::APPROXIMATE);
    EXPECT_TRUE(difference.Compare(*made, read<Message>(wanted))) << toJson(*made);
    EXPECT_EQ(resolved(*made)->SerializeAsString().size(), made->SerializeAsString().size());
}

TEST(Resolve, FillsInWhatIsNotSaid) {
    constexpr const char* light =
        R"({"direction": [-0.39801487608399566, 0.5970223141259934, 0.6965260331469923],
        "ambient": 0.15, "diffuse": 0.85, "specular": 0})";
    expectResolved<proto::Light>("{}", light);
    expectResolved<proto::Light>(R"({"direction": [0, 3, 4], "fixed": true, "diffuse": 0.5, "shadow": true})",
                                 R"({"direction": [0, 0.6, 0.8], "fixed": true, "ambient": 0.15,
                                     "diffuse": 0.5, "specular": 0, "shadow": true})");
    expectResolved<proto::MeshStyle>(
        "{}", fmt::format(R"({{"color": [0.8, 0.8, 0.8], "opacity": 1, "light": {}}})", light).c_str());
    expectResolved<proto::StippleStyle>(
        R"({"spacingPixels": 7})",
        fmt::format(R"({{"spacingPixels": 7, "jitter": 0.5, "gamma": 1, "opacity": 1, "light": {}}})", light)
            .c_str());
    expectResolved<proto::ParticlesStyle>(
        "{}", R"({"volume": {"colorMap": "inferno"}, "points": {"linked": true}})");
    expectResolved<proto::ParticlesStyle>(
        R"({"points": {"linked": false, "curve": [{"density": 1}]}})",
        R"({"volume": {"colorMap": "inferno"}, "points": {"linked": false, "curve": [{"density": 1}]}})");
    expectResolved<proto::HybridStyle>(
        "{}",
        fmt::format(R"({{"pointShape": "gaussian", "pointOpacity": 1, "silhouettes": 0, "gradientOpacity": 0,
                              "light": {}}})",
                    light)
            .c_str());
    expectResolved<proto::InkStyle>(
        R"({"ink": {}})",
        fmt::format(R"({{"silhouettes": {{"mode": "adjusted", "importance": 0.05, "creaseDegrees": 60}},
            "hatch": {{"strength": 1, "segments": "growing"}}, "ink": {{"strength": 0.5, "complexity": 0.3}},
            "light": {}, "occlusion": 0.6}})",
                    light)
            .c_str());
}

TEST(Resolve, NamesWhatIsWrong) {
    EXPECT_EQ(errorOf<proto::MeshStyle>(R"({"color": [1, 2, 0]})"),
              "color[1]: 2 is not a number from 0 to 1");
    EXPECT_EQ(errorOf<proto::MeshStyle>(R"({"color": [1, 0]})"), "color: 3 numbers are needed, not 2");
    EXPECT_EQ(errorOf<proto::MeshStyle>(R"({"light": {"direction": [0, 0, 0]}})"),
              "light.direction: a direction must not be zero");
    EXPECT_EQ(errorOf<proto::MeshStyle>(R"({"light": {"diffuse": 2}})"),
              "light.diffuse: 2 is not a number from 0 to 1");
    EXPECT_EQ(errorOf<proto::Camera>(R"({"target": [0, 0, 0]})"), "eye: 3 numbers are needed, not 0");
    EXPECT_EQ(errorOf<proto::InkStyle>(R"({"silhouettes": {"mode": "some"}})"),
              "silhouettes.mode: \"some\" is not known: there are none, all, important, adjusted");
    EXPECT_EQ(errorOf<proto::HybridStyle>(R"({"curve": [{"value": 1}, {"value": 2, "opacity": 3}]})"),
              "curve[1]: 3 is not a number from 0 to 1");
    EXPECT_EQ(errorOf<proto::HybridStyle>(R"({"curve": [{"value": 1, "color": [0, 0, -1]}]})"),
              "curve[0].color[2]: -1 is not a number from 0 to 1");
    EXPECT_EQ(errorOf<proto::HybridStyle>(R"({"curve": [{"value": 1}, {"value": 0.5}]})"),
              "curve[1]: knots must ascend");
    EXPECT_EQ(errorOf<proto::HybridStyle>(R"({"clipPlanes": [{"normal": [1, 0, 0]}, {}]})"),
              "clipPlanes[1].normal: 3 numbers are needed, not 0");
    EXPECT_NE(errorOf<proto::VolumeStyle>(R"({"colorMap": "Inferno"})").find("colorMap: no colour map is"),
              std::string::npos);
}

}  // namespace
}  // namespace mote
