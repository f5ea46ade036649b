// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which points of a step a selection holds: docs/SELECTIONS.md, "Selections". A function without state; uses
// all threads of the calling arena.
#pragma once

#include <cstdint>
#include <functional>

#include "protocol/base/error.h"
#include "protocol/scene/selection.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

/// Where the selection, or a part of it, was made in another step, the points of that step are found first
/// and then their ids here. A NaN belongs to no range, no polygon and no share. Stops with a `cancelled`
/// error where `cancelled`, which may be empty and is asked on several threads at once, says so. Errors:
/// notFound, at the field (a column that the dataset does not have, no columns or no ids at all: says how to
/// make them; a step that is not there); corrupt.
Result<PointMask> selectPoints(const Selection& selection, const RunSteps& run, std::uint32_t step,
                               const std::function<bool()>& cancelled);

}  // namespace mote::storage
