// SPDX-License-Identifier: GPL-3.0-or-later
//
// What layers of particles are drawn with besides the points of a step: values by which points are coloured,
// the ways of particles. Computed from the columns beside the points, on threads
// that load: pure functions that use all threads of the calling arena, stop with a `cancelled` error if
// they are told to, and throw storage::StorageError.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/transfer_function.h"
#include "server/render/layers/particles/point_paths.h"
#include "server/render/plan/point_values.h"
#include "storage/numbers/run_steps.h"

namespace mote::render {

using Cancelled = std::function<bool()>;

/// The values of a step's points by a column or derived quantity; `points`: of these alone, in their order;
/// empty: of all. Errors: notFound, at the column.
Result<std::shared_ptr<const PointValues>> pointValues(const storage::StepNumbers& step,
                                                       const std::string& column, const ValueRange& range,
                                                       std::span<const std::uint32_t> points,
                                                       const Cancelled& cancelled);

/// The ways of particles by their ids, through the places of their points; a step that lacks one is passed
/// over. Of several points of an id the first counts. Errors: notFound (the dataset has no ids).
Result<std::shared_ptr<const PointPaths>> pointPaths(const storage::RunSteps& run,
                                                     std::span<const std::uint64_t> ids,
                                                     const Cancelled& cancelled);

}  // namespace mote::render
