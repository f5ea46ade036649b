// SPDX-License-Identifier: GPL-3.0-or-later
//
// FieldVisitor: sees the fields of a style beside those of another of its kind (visitFields), so that what
// is done with all of them (what lies between two styles, longer pixels) is written once and not once a kind.
// Who calls owns it; one thread.
#pragma once

#include <functional>
#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"
#include "protocol/scene/length_scale.h"
#include "protocol/scene/mix.h"

namespace mote {

class FieldVisitor {
  public:
    virtual ~FieldVisitor() = default;
    /// A field that has something in between: `set` gives it what lies at a share of the way to the other's,
    /// 0 to 1.
    virtual void between(const std::function<void(double share)>& set) = 0;
    /// The same of a length on the screen.
    virtual void pixels(ScreenLength& value, const ScreenLength& other, const LengthField& field) = 0;
    /// A field that has nothing in between: a word, or what one has and the other leaves to its dataset.
    virtual void word(bool same) = 0;

    /// One that is there only where it is said.
    void pixels(double& value, double other, const LengthField& field) {
        ScreenLength length(value);
        pixels(length, ScreenLength(other), field);
        value = length.value();
    }
    void number(double& value, double other) {
        between([&, from = value](double share) { value = mix(from, other, share); });
    }
    void vector(glm::dvec3& value, const glm::dvec3& other) {
        between([&, from = value](double share) { value = mix(from, other, share); });
    }
};

/// Makes a valid style that of a layer's message, complete: parsing gives it again.
void writeStyle(const google::protobuf::Message& style, proto::Layer& layer);

/// Shows all fields of a style beside those of another. What the visitor sets keeps the style valid.
void visitFields(proto::ParticlesStyle& style, const proto::ParticlesStyle& other, FieldVisitor& visitor);
void visitFields(proto::HybridStyle& style, const proto::HybridStyle& other, FieldVisitor& visitor);
void visitFields(proto::InkStyle& style, const proto::InkStyle& other, FieldVisitor& visitor);
void visitFields(google::protobuf::Message& style, const google::protobuf::Message& other,
                 FieldVisitor& visitor);

}  // namespace mote
