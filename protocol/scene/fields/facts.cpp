// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/fields/facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <unordered_map>

#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"

namespace mote {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

namespace {

using FactsOfFields = std::unordered_map<const FieldDescriptor*, const proto::Facts*>;

void addFacts(const google::protobuf::Descriptor& type, FactsOfFields& facts) {
    for (int i = 0; i < type.field_count(); ++i)
        facts.emplace(type.field(i), &type.field(i)->options().GetExtension(proto::is));
    for (int i = 0; i < type.nested_type_count(); ++i) addFacts(*type.nested_type(i), facts);
}

/// Of all fields of the schema: to look into their options takes ten times as long.
FactsOfFields schemaFacts() {
    FactsOfFields facts;
    const auto& schema = *proto::View::descriptor()->file();
    for (int i = 0; i < schema.message_type_count(); ++i) addFacts(*schema.message_type(i), facts);
    return facts;
}

}  // namespace

const proto::Facts& factsOf(const FieldDescriptor& field) {
    static const FactsOfFields facts = schemaFacts();
    const auto found = facts.find(&field);
    return found != facts.end() ? *found->second : proto::Facts::default_instance();
}

std::optional<Ends> endsOf(const FieldDescriptor& field) {
    return endsOf(factsOf(field));
}

std::optional<Ends> endsOf(const proto::Facts& facts) {
    if (facts.as() == proto::Facts::COLOR) return Ends{0.0, 1.0};
    if (facts.as() == proto::Facts::DIRECTION) return Ends{-1e6, 1e6};
    if (!facts.has_from()) return std::nullopt;
    return Ends{facts.from(), facts.to()};
}

int countOf(const FieldDescriptor& field) {
    const auto& facts = factsOf(field);
    const bool triple = facts.as() == proto::Facts::COLOR || facts.as() == proto::Facts::DIRECTION;
    return triple ? 3 : static_cast<int>(facts.count());
}

double saidNumber(const Message& message, const FieldDescriptor& field) {
    const auto& reflection = *message.GetReflection();
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_UINT32:
            return reflection.GetUInt32(message, &field);
        case FieldDescriptor::CPPTYPE_UINT64:
            return static_cast<double>(reflection.GetUInt64(message, &field));
        default:
            return reflection.GetDouble(message, &field);
    }
}

double numberOf(const Message& message, int number) {
    const auto& field = *message.GetDescriptor()->FindFieldByNumber(number);
    const bool said = !field.has_presence() || message.GetReflection()->HasField(message, &field);
    return said ? saidNumber(message, field) : factsOf(field).default_(0);
}

std::string helpOf(const FieldDescriptor& field) {
    const auto& facts = factsOf(field);
    std::string text = facts.help();
    if (!facts.default_word().empty()) text += "; default " + facts.default_word();
    if (!facts.default_().empty()) text += fmt::format("; default {}", facts.default_(0));
    return text;
}

std::optional<glm::dvec3> colorOf(const Message& message, int number) {
    const auto& field = *message.GetDescriptor()->FindFieldByNumber(number);
    const auto& reflection = *message.GetReflection();
    const auto& usual = factsOf(field).default_();
    const bool said = reflection.FieldSize(message, &field) > 0;
    if (!said && usual.empty()) return std::nullopt;
    glm::dvec3 color;
    for (int i = 0; i < 3; ++i) color[i] = said ? reflection.GetRepeatedDouble(message, &field, i) : usual[i];
    return srgbToLinear(color);
}

ScreenLength lengthOf(const Message& message, const FieldDescriptor& field) {
    const auto& reflection = *message.GetReflection();
    if (reflection.HasField(message, &field)) return reflection.GetDouble(message, &field);
    MOTE_CHECK(!factsOf(field).default_().empty());
    return ScreenLength::usual(factsOf(field).default_(0));
}

ScreenLength lengthOf(const Message& message, int number) {
    return lengthOf(message, *message.GetDescriptor()->FindFieldByNumber(number));
}

LengthField lengthField(std::string_view path) {
    const auto* type = proto::Layer::descriptor();
    const FieldDescriptor* field = nullptr;
    for (std::string_view rest = path; !rest.empty();) {
        const auto end = std::min(rest.find('.'), rest.size());
        field = type->FindFieldByCamelcaseName(std::string(rest.substr(0, end)));
        MOTE_CHECK(field != nullptr);
        type = field->message_type();
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    MOTE_CHECK(field != nullptr);  // of a path that is not empty
    const auto ends = endsOf(*field).value();
    return {path, ends.least, ends.greatest};
}

}  // namespace mote
