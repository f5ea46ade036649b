// SPDX-License-Identifier: GPL-3.0-or-later
//
// Styles that are their messages (style_kinds.h): written and shown to visitors by what the schema says of
// their fields.
#include <fmt/format.h>

#include <string>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using proto::Facts;

/// The field of a layer that holds styles of this type.
const FieldDescriptor& styleField(const Message& style) {
    const auto& kinds = *proto::Layer::descriptor()->FindOneofByName("kind");
    for (int i = 0; i < kinds.field_count(); ++i) {
        if (kinds.field(i)->message_type() == style.GetDescriptor()) return *kinds.field(i);
    }
    MOTE_CHECK(false);
    return *kinds.field(0);
}

/// A field of a message beside the same field of another.
class FieldPair {
  public:
    FieldPair(Message& value, const Message& other, const FieldDescriptor& field)
        : value_(value), other_(other), field_(field), reflection_(*value.GetReflection()) {}

    void show(const std::string& path, FieldVisitor& visitor) {
        const auto type = field_.cpp_type();
        if (type == FieldDescriptor::CPPTYPE_MESSAGE) return showMessage(path, visitor);
        if (type != FieldDescriptor::CPPTYPE_DOUBLE) return visitor.word(sameWord());
        if (field_.is_repeated()) return showNumbers(visitor);
        if (factsOf(field_).as() == Facts::LENGTH) return showLength(path, visitor);
        if (field_.has_presence() && has(value_) != has(other_)) return visitor.word(false);
        if (field_.has_presence() && !has(value_)) return;
        visitor.between([&, from = numberOf(value_), to = numberOf(other_)](double share) {
            reflection_.SetDouble(&value_, &field_, mix(from, to, share));
        });
    }

  private:
    using Numbers = google::protobuf::RepeatedField<double>;

    bool has(const Message& message) const { return reflection_.HasField(message, &field_); }
    double numberOf(const Message& message) const { return reflection_.GetDouble(message, &field_); }

    bool sameWord() const {
        if (field_.cpp_type() == FieldDescriptor::CPPTYPE_BOOL)
            return reflection_.GetBool(value_, &field_) == reflection_.GetBool(other_, &field_);
        MOTE_CHECK(field_.cpp_type() == FieldDescriptor::CPPTYPE_STRING);
        return reflection_.GetString(value_, &field_) == reflection_.GetString(other_, &field_);
    }

    void showLength(const std::string& path, FieldVisitor& visitor) {
        const auto ends = endsOf(field_).value();
        ScreenLength length = lengthOf(value_, field_);
        visitor.pixels(length, lengthOf(other_, field_), {path, ends.least, ends.greatest});
        if (length.said()) reflection_.SetDouble(&value_, &field_, length.value());
    }

    Numbers numbersOf(const Message& message) const {
        Numbers numbers;
        for (int i = 0; i < reflection_.FieldSize(message, &field_); ++i)
            numbers.Add(reflection_.GetRepeatedDouble(message, &field_, i));
        return numbers;
    }

    /// A colour or a direction; of both there are three numbers, or none.
    void showNumbers(FieldVisitor& visitor) {
        const Numbers from = numbersOf(value_), to = numbersOf(other_);
        if (from.empty() != to.empty()) return visitor.word(false);
        if (from.empty()) return;
        visitor.between([&](double share) {
            Numbers mixed;
            if (factsOf(field_).as() == Facts::COLOR)
                writeColor(mix(readColor(from), readColor(to), share), &mixed);
            else
                writeVector(mixDirections(readVector(from), readVector(to), share), &mixed);
            for (int i = 0; i < mixed.size(); ++i)
                reflection_.SetRepeatedDouble(&value_, &field_, i, mixed[i]);
        });
    }

    void showMessage(const std::string& path, FieldVisitor& visitor);

    Message& value_;
    const Message& other_;
    const FieldDescriptor& field_;
    const google::protobuf::Reflection& reflection_;
};

void showFields(Message& value, const Message& other, const std::string& path, FieldVisitor& visitor) {
    const auto& type = *value.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
        const auto& field = *type.field(i);
        FieldPair(value, other, field).show(fmt::format("{}.{}", path, field.json_name()), visitor);
    }
}

void FieldPair::showMessage(const std::string& path, FieldVisitor& visitor) {
    if (has(value_) != has(other_)) return visitor.word(false);
    if (!has(value_)) return;
    showFields(*reflection_.MutableMessage(&value_, &field_), reflection_.GetMessage(other_, &field_), path,
               visitor);
}

}  // namespace

void writeStyle(const Message& style, const glm::dvec3&, proto::Layer& layer) {
    layer.GetReflection()->MutableMessage(&layer, &styleField(style))->CopyFrom(style);
}

void visitFields(Message& style, const Message& other, FieldVisitor& visitor) {
    showFields(style, other, styleField(style).json_name(), visitor);
}

}  // namespace mote
