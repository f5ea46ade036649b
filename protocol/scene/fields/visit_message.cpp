// SPDX-License-Identifier: GPL-3.0-or-later
//
// Messages that are what layers and views hold: shown to visitors, and styles written, by what the schema
// says of their fields.
#include <fmt/format.h>
#include <google/protobuf/reflection.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "protocol/scene/field_visitor.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using proto::Facts;

/// The field of a layer or a view that holds messages of this type: styles, and what stands beside them.
const FieldDescriptor& partField(const Message& part) {
    for (const auto* const type : {proto::Layer::descriptor(), proto::View::descriptor()}) {
        for (int i = 0; i < type->field_count(); ++i) {
            if (type->field(i)->message_type() == part.GetDescriptor()) return *type->field(i);
        }
    }
    MOTE_CHECK(false);
    return *proto::Layer::descriptor()->field(0);
}

using Numbers = google::protobuf::RepeatedField<double>;

Numbers numbersOf(const Message& message, const FieldDescriptor& field) {
    const auto& reflection = *message.GetReflection();
    Numbers numbers;
    for (int i = 0; i < reflection.FieldSize(message, &field); ++i)
        numbers.Add(reflection.GetRepeatedDouble(message, &field, i));
    return numbers;
}

void setNumbers(Message& message, const FieldDescriptor& field, const Numbers& numbers) {
    const auto& reflection = *message.GetReflection();
    reflection.ClearField(&message, &field);
    for (const double number : numbers) reflection.AddDouble(&message, &field, number);
}

/// A field of a message beside the same field of another.
class FieldPair {
  public:
    FieldPair(Message& value, const Message& other, const FieldDescriptor& field)
        : value_(value), other_(other), field_(field), reflection_(*value.GetReflection()) {}

    void show(const std::string& path, FieldVisitor& visitor) {
        const auto type = field_.cpp_type();
        if (type == FieldDescriptor::CPPTYPE_MESSAGE) return showMessages(path, visitor);
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
    bool has(const Message& message) const { return reflection_.HasField(message, &field_); }
    double numberOf(const Message& message) const { return reflection_.GetDouble(message, &field_); }

    bool sameWord() const {
        if (field_.cpp_type() == FieldDescriptor::CPPTYPE_BOOL)
            return reflection_.GetBool(value_, &field_) == reflection_.GetBool(other_, &field_);
        if (field_.cpp_type() == FieldDescriptor::CPPTYPE_UINT64) return sameIds();
        MOTE_CHECK(field_.cpp_type() == FieldDescriptor::CPPTYPE_STRING);
        return reflection_.GetString(value_, &field_) == reflection_.GetString(other_, &field_);
    }

    bool sameIds() const {
        const auto ids = [this](const Message& message) {
            return reflection_.GetRepeatedFieldRef<std::uint64_t>(message, &field_);
        };
        return std::equal(ids(value_).begin(), ids(value_).end(), ids(other_).begin(), ids(other_).end());
    }

    void showLength(const std::string& path, FieldVisitor& visitor) {
        const auto ends = endsOf(field_).value();
        ScreenLength length = lengthOf(value_, field_);
        visitor.pixels(length, lengthOf(other_, field_), {path, ends.least, ends.greatest});
        if (length.said()) reflection_.SetDouble(&value_, &field_, length.value());
    }

    /// A colour, a direction, or others, of which there are as many in both, or they do not mix.
    void showNumbers(FieldVisitor& visitor) {
        const Numbers from = numbersOf(value_, field_), to = numbersOf(other_, field_);
        if (from.size() != to.size()) return visitor.word(false);
        if (from.empty()) return;
        visitor.between([&](double share) {
            Numbers mixed;
            if (factsOf(field_).as() == Facts::COLOR)
                writeColor(mix(readColor(from), readColor(to), share), &mixed);
            else if (factsOf(field_).as() == Facts::DIRECTION || factsOf(field_).as() == Facts::NORMAL)
                writeVector(mixDirections(readVector(from), readVector(to), share), &mixed);
            else
                for (int i = 0; i < from.size(); ++i) mixed.Add(mix(from[i], to[i], share));
            setNumbers(value_, field_, mixed);
        });
    }

    ColoredCurve curveOf(const Message& message) const {
        std::vector<Curve::Knot> knots;
        std::vector<glm::dvec3> colors;
        for (int i = 0; i < reflection_.FieldSize(message, &field_); ++i) {
            const Message& knot = reflection_.GetRepeatedMessage(message, &field_, i);
            const auto& parts = *knot.GetReflection();
            const auto& type = *knot.GetDescriptor();
            knots.push_back({parts.GetDouble(knot, type.field(0)), parts.GetDouble(knot, type.field(1))});
            if (type.field_count() < 3) continue;
            const Numbers color = numbersOf(knot, *type.field(2));
            if (!color.empty()) colors.push_back(readColor(color));
        }
        return {Curve::create(std::move(knots), -Curve::largest, Curve::largest).value(), std::move(colors)};
    }

    void setCurve(const ColoredCurve& curve) {
        reflection_.ClearField(&value_, &field_);
        for (std::size_t i = 0; i < curve.curve.knots().size(); ++i) {
            Message& knot = *reflection_.AddMessage(&value_, &field_);
            const auto& parts = *knot.GetReflection();
            const auto& type = *knot.GetDescriptor();
            parts.SetDouble(&knot, type.field(0), curve.curve.knots()[i].x);
            parts.SetDouble(&knot, type.field(1), curve.curve.knots()[i].y);
            if (curve.colors.empty()) continue;
            Numbers color;
            writeColor(curve.colors[i], &color);
            setNumbers(knot, *type.field(2), color);
        }
    }

    /// Knots, one of which at least is said.
    void showCurve(FieldVisitor& visitor) {
        const auto from = curveOf(value_), to = curveOf(other_);
        if (!canMix(from, to)) return visitor.word(from == to);
        visitor.between([&](double share) { setCurve(mixCurves(from, to, share)); });
    }

    void showMessages(const std::string& path, FieldVisitor& visitor);

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

void FieldPair::showMessages(const std::string& path, FieldVisitor& visitor) {
    if (!field_.is_repeated()) return showMessage(path, visitor);
    const int count = reflection_.FieldSize(value_, &field_);
    const int others = reflection_.FieldSize(other_, &field_);
    const bool knots = factsOf(field_).as() == Facts::KNOTS;
    if (&value_ == &other_) return;  // there is nothing in between, and no length within
    if (knots ? (count == 0) != (others == 0) : count != others) return visitor.word(false);
    if (knots && count > 0) return showCurve(visitor);
    for (int i = 0; !knots && i < count; ++i)
        showFields(*reflection_.MutableRepeatedMessage(&value_, &field_, i),
                   reflection_.GetRepeatedMessage(other_, &field_, i), path, visitor);
}

void FieldPair::showMessage(const std::string& path, FieldVisitor& visitor) {
    if (has(value_) != has(other_)) return visitor.word(false);
    if (!has(value_)) return;
    showFields(*reflection_.MutableMessage(&value_, &field_), reflection_.GetMessage(other_, &field_), path,
               visitor);
}

}  // namespace

void writeStyle(const Message& style, proto::Layer& layer) {
    layer.GetReflection()->MutableMessage(&layer, &partField(style))->CopyFrom(style);
}

void visitFields(Message& style, const Message& other, FieldVisitor& visitor) {
    showFields(style, other, partField(style).json_name(), visitor);
}

}  // namespace mote
