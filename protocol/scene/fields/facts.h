// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the schema says of fields beyond their types (protocol/options.proto). Pure functions, safe on any
// thread.
#pragma once

#include <google/protobuf/message.h>

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/mote.pb.h"
#include "protocol/options.pb.h"
#include "protocol/scene/length_scale.h"

namespace mote {

/// Empty where the schema says nothing.
const proto::Facts& factsOf(const google::protobuf::FieldDescriptor& field);

struct Ends {
    double least, greatest;
};

/// Of a number, or of each number of a list; none where it may be any.
std::optional<Ends> endsOf(const proto::Facts& facts);
std::optional<Ends> endsOf(const google::protobuf::FieldDescriptor& field);

/// What --help and tables say of a field: its words, and its default.
std::string helpOf(const google::protobuf::FieldDescriptor& field);

/// How many numbers a list has that is said; 0: any.
int countOf(const google::protobuf::FieldDescriptor& field);

/// A number as the message has it: a double, or a whole one of no sign.
double saidNumber(const google::protobuf::Message& message, const google::protobuf::FieldDescriptor& field);

/// A number: as the message says it, or its default. Whole numbers of 53 bits are exact.
double numberOf(const google::protobuf::Message& message, int number);

/// A colour, linear RGB: as the message says it, or its default; none where it follows from other things.
std::optional<glm::dvec3> colorOf(const google::protobuf::Message& message, int number);

/// A length on the screen: as the message says it, or the usual one.
ScreenLength lengthOf(const google::protobuf::Message& message,
                      const google::protobuf::FieldDescriptor& field);
ScreenLength lengthOf(const google::protobuf::Message& message, int number);

/// A length of a layer, by its path there: "ink.hatch.width".
LengthField lengthField(std::string_view path);

}  // namespace mote
