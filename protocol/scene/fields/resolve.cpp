// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/fields/resolve.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <string>

#include "protocol/base/check.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/fields/facts.h"

namespace mote {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using proto::Facts;

constexpr int mostOfCurve = 256;      // knots
constexpr double leastLength = 1e-6;  // of a direction

/// A field as a message has it, to be checked.
class SaidField {
  public:
    SaidField(const Message& message, const FieldDescriptor& field)
        : message_(message), field_(field), facts_(factsOf(field)), reflection_(*message.GetReflection()) {}

    Status check() const {
        switch (field_.cpp_type()) {
            case FieldDescriptor::CPPTYPE_DOUBLE:
                return field_.is_repeated() ? checkNumbers() : checkNumber();
            case FieldDescriptor::CPPTYPE_UINT32:
            case FieldDescriptor::CPPTYPE_UINT64:
                return field_.is_repeated() ? success() : checkNumber();
            case FieldDescriptor::CPPTYPE_STRING:
                return field_.is_repeated() ? success() : checkWord();
            case FieldDescriptor::CPPTYPE_MESSAGE:
                return facts_.as() == Facts::KNOTS ? checkKnots() : checkMessages();
            default:
                return success();
        }
    }

  private:
    int size() const { return reflection_.FieldSize(message_, &field_); }

    Status checkEnds(double value) const {
        if (const auto ends = endsOf(facts_))
            MOTE_RETURN_IF_ERROR(checkRange(value, ends->least, ends->greatest, ""));
        return success();
    }

    Status checkNumber() const {
        const bool there = !field_.has_presence() || reflection_.HasField(message_, &field_);
        return there ? checkEnds(saidNumber(message_, field_)) : success();
    }

    Status checkNumbers() const {
        if (size() == 0 && !facts_.needed()) return success();
        if (const int count = countOf(field_); count > 0 && size() != count)
            return invalid("", fmt::format("{} numbers are needed, not {}", count, size()));
        glm::dvec3 vector(0.0);
        for (int i = 0; i < size(); ++i) {
            const double number = reflection_.GetRepeatedDouble(message_, &field_, i);
            MOTE_RETURN_IF_ERROR(checkEnds(number), fmt::format("[{}]", i));
            vector[i % 3] = number;
        }
        if (facts_.as() != Facts::DIRECTION || glm::length(vector) > leastLength) return success();
        return invalid("", "a direction must not be zero");
    }

    Status checkWord() const {
        std::string scratch;
        const std::string& word = reflection_.GetStringReference(message_, &field_, &scratch);
        const auto& known = facts_.one_of();
        if (word.empty()) return success();
        if (facts_.as() == Facts::COLOR_MAP) {
            MOTE_RETURN_IF_ERROR(ColorMap::find(word));
            return success();
        }
        if (known.empty() || std::find(known.begin(), known.end(), word) != known.end()) return success();
        return invalid(
            "", fmt::format("\"{}\" is not known: there are {}", word.substr(0, 60), fmt::join(known, ", ")));
    }

    Status checkMessages() const {
        if (!field_.is_repeated()) {
            if (!reflection_.HasField(message_, &field_)) return success();
            return checkFields(reflection_.GetMessage(message_, &field_));
        }
        for (int i = 0; i < size(); ++i)
            MOTE_RETURN_IF_ERROR(checkFields(reflection_.GetRepeatedMessage(message_, &field_, i)),
                                 fmt::format("[{}]", i));
        return success();
    }

    Status checkKnots() const {
        if (size() > mostOfCurve)
            return invalid("", fmt::format("a curve has 1 to {} knots, not {}", mostOfCurve, size()));
        double before = -std::numeric_limits<double>::infinity();
        for (int i = 0; i < size(); ++i) {
            const Message& knot = reflection_.GetRepeatedMessage(message_, &field_, i);
            MOTE_RETURN_IF_ERROR(checkKnot(knot), fmt::format("[{}]", i));
            const double here = knot.GetReflection()->GetDouble(knot, knot.GetDescriptor()->field(0));
            if (here < before) return invalid(fmt::format("[{}]", i), "knots must ascend");
            before = here;
        }
        return success();
    }

    /// Its numbers are named as the knot.
    static Status checkKnot(const Message& knot) {
        const auto& type = *knot.GetDescriptor();
        for (int i = 0; i < type.field_count(); ++i) {
            const auto& field = *type.field(i);
            MOTE_RETURN_IF_ERROR(SaidField(knot, field).check(),
                                 field.is_repeated() ? std::string_view(field.json_name()) : "");
        }
        return success();
    }

    const Message& message_;
    const FieldDescriptor& field_;
    const Facts& facts_;
    const google::protobuf::Reflection& reflection_;
};

Status checkThose(const Message& message, bool messagesToo) {
    const auto& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
        const auto& field = *type.field(i);
        if (field.message_type() != nullptr && !messagesToo) continue;
        MOTE_RETURN_IF_ERROR(SaidField(message, field).check(), field.json_name());
    }
    return success();
}

/// What cannot be one stays as it is, to be refused.
void makeUnit(const FieldDescriptor& field, Message& message) {
    const auto& reflection = *message.GetReflection();
    if (!SaidField(message, field).check().ok()) return;
    glm::dvec3 direction;
    for (int i = 0; i < 3; ++i) direction[i] = reflection.GetRepeatedDouble(message, &field, i);
    constexpr double rounding = 1e-15;  // what is unit stays as it is
    if (std::abs(glm::dot(direction, direction) - 1.0) < rounding) return;
    direction = glm::normalize(direction);
    for (int i = 0; i < 3; ++i) reflection.SetRepeatedDouble(&message, &field, i, direction[i]);
}

void fillNumbers(const FieldDescriptor& field, Message& message) {
    const auto& reflection = *message.GetReflection();
    const auto& facts = factsOf(field);
    if (reflection.FieldSize(message, &field) == 0) {
        for (const double number : facts.default_()) reflection.AddDouble(&message, &field, number);
    }
    if (facts.as() == Facts::DIRECTION) makeUnit(field, message);
}

void fillMessages(const FieldDescriptor& field, Message& message) {
    const auto& reflection = *message.GetReflection();
    if (!field.is_repeated()) {
        if (factsOf(field).filled() || reflection.HasField(message, &field))
            fillIn(*reflection.MutableMessage(&message, &field));
        return;
    }
    for (int i = 0; i < reflection.FieldSize(message, &field); ++i)
        fillIn(*reflection.MutableRepeatedMessage(&message, &field, i));
}

/// A single number, word or switch.
void fillField(const FieldDescriptor& field, Message& message) {
    const auto& reflection = *message.GetReflection();
    const auto& facts = factsOf(field);
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
        if (!facts.default_word().empty() && !reflection.HasField(message, &field))
            reflection.SetString(&message, &field, facts.default_word());
        return;
    }
    if (facts.default_().empty() || facts.as() == Facts::LENGTH || !field.has_presence() ||
        reflection.HasField(message, &field))
        return;
    const double number = facts.default_(0);
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_BOOL:
            return reflection.SetBool(&message, &field, number != 0.0);
        case FieldDescriptor::CPPTYPE_UINT32:
            return reflection.SetUInt32(&message, &field, static_cast<std::uint32_t>(number));
        case FieldDescriptor::CPPTYPE_UINT64:
            return reflection.SetUInt64(&message, &field, static_cast<std::uint64_t>(number));
        default:
            reflection.SetDouble(&message, &field, number);
    }
}

}  // namespace

void fillIn(Message& message) {
    const auto& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
        const auto& field = *type.field(i);
        if (field.message_type() != nullptr)
            fillMessages(field, message);
        else if (!field.is_repeated())
            fillField(field, message);
        else if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE)
            fillNumbers(field, message);
    }
}

Status checkFields(const Message& message) {
    return checkThose(message, true);
}

Status checkOwnFields(const Message& message) {
    return checkThose(message, false);
}

}  // namespace mote
