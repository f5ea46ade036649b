// SPDX-License-Identifier: GPL-3.0-or-later
//
// PickedPoint: the answer to a PickQuery as a value, held to what was asked and to itself. Units as in
// docs/NUMBERS.md.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

struct PickedPoint {
    struct Value {
        std::string name, unit;
        double value = 0.0;
    };
    std::uint32_t step = 0;
    std::uint32_t layer = 0;   ///< of the view that was asked about
    std::uint64_t point = 0;   ///< in the dataset's order
    std::uint64_t row = 0;     ///< in the source
    double distance = 0.0;     ///< pixels from the place that was asked for
    glm::dvec3 position{0.0};  ///< layer space
    double density = 0.0;      ///< scaled log density of its leaf
    std::vector<Value> values;
    std::optional<std::uint64_t> id;
};

/// Nothing where there is no point. Errors: corrupt.
Result<std::optional<PickedPoint>> pickedOf(const QueryAnswer& answer, const proto::PickQuery& asked);

}  // namespace mote::client
