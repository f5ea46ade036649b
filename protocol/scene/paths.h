// SPDX-License-Identifier: GPL-3.0-or-later
//
// Paths: whose ways through all steps of a run are lines in the picture (docs/PICTURE.md, "Paths"). A value;
// a parsed one is valid in itself.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/length_scale.h"

namespace mote {

struct Paths {
    static constexpr int maxIds = 1000;

    std::vector<std::uint64_t> ids;   ///< ascending, without repetition
    std::optional<glm::dvec3> color;  ///< linear RGB; absent: as of the layer's points
    ScreenLength width = 0.0;         ///< pixels

    bool operator==(const Paths&) const = default;
};

/// Fills every default. Errors: too many ids, a number out of range.
Result<Paths> parsePaths(const proto::Paths& message);

/// Complete: parsing it gives the value again, the colour to rounding.
proto::Paths toProto(const Paths& paths);

void visitFields(Paths& paths, const Paths& other, FieldVisitor& visitor);

}  // namespace mote
