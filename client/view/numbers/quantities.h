// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a particle of a dataset has a number of: its columns, and what a server derives from them
// (docs/NUMBERS.md). Pure functions; a manifest that nobody has checked does no harm.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/view/knot_curve.h"
#include "protocol/mote.pb.h"

namespace mote::client {

struct Quantity {
    std::string name;
    std::string unit;
    std::optional<Interval> range = {};  ///< of all steps; none of what is derived, or has no extent
};

/// Columns in the dataset's order, then what can be derived from them; none of a dataset without columns.
std::vector<Quantity> quantitiesOf(const proto::ParticlesManifest& manifest);

/// Null where there is none of this name.
const Quantity* findQuantity(const std::vector<Quantity>& quantities, std::string_view name);

}  // namespace mote::client
