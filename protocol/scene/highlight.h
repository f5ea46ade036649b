// SPDX-License-Identifier: GPL-3.0-or-later
//
// Highlight: which points of a layer are drawn over the others, and how (docs/PICTURE.md, "Highlights"). A
// value; a parsed one is valid in itself.
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/selection.h"

namespace mote {

struct Highlight {
    Selection selection;
    glm::dvec3 color{0.0};            ///< linear RGB
    std::optional<double> pointSize;  ///< pixels; absent: the layer's
    double opacity = 0.0;             ///< of one point, at most ParticlesStyle::opacityLimit

    bool operator==(const Highlight&) const = default;
};

/// Fills every default. Errors: of the selection, a number out of range.
Result<Highlight> parseHighlight(const proto::Highlight& message, const NamedSelectionMessages& named);

/// Complete: parsing it gives the value again, the colour to rounding.
proto::Highlight toProto(const Highlight& highlight);

void visitFields(Highlight& highlight, const Highlight& other, FieldVisitor& visitor);

}  // namespace mote
