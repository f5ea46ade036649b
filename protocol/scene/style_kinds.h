// SPDX-License-Identifier: GPL-3.0-or-later
//
// What every kind of style can do besides being parsed: become a message again, and show its fields. A kind's
// functions stand where it is parsed (particles_style.cpp, ...). Pure functions.
#pragma once

#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/hybrid_style.h"
#include "protocol/scene/ink_style.h"
#include "protocol/scene/particles_style.h"

namespace mote {

/// Makes a valid style that of a layer's message, complete: parsing gives it again. `background`: of its
/// view, linear RGB, to the digit as the view's message gives it.
void writeStyle(const ParticlesStyle& style, const glm::dvec3& background, proto::Layer& layer);
void writeStyle(const HybridStyle& style, const glm::dvec3& background, proto::Layer& layer);
void writeStyle(const InkStyle& style, const glm::dvec3& background, proto::Layer& layer);
/// Of a kind whose style is its message, resolved (fields/visit_message.cpp).
void writeStyle(const google::protobuf::Message& style, const glm::dvec3& background, proto::Layer& layer);

/// Shows all fields of a style beside those of another. What the visitor sets keeps the style valid.
void visitFields(ParticlesStyle& style, const ParticlesStyle& other, FieldVisitor& visitor);
void visitFields(HybridStyle& style, const HybridStyle& other, FieldVisitor& visitor);
void visitFields(InkStyle& style, const InkStyle& other, FieldVisitor& visitor);
void visitFields(google::protobuf::Message& style, const google::protobuf::Message& other,
                 FieldVisitor& visitor);

}  // namespace mote
