// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which steps of a run are meant by "FIRST:LAST:STRIDE" of step indices, last included. Pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace mote {

/// The form alone. Also "N", "FIRST:LAST"; an empty FIRST is 0, an empty LAST the run's last step. Errors:
/// invalidArgument, at "steps".
Status checkStepRange(std::string_view text);

/// Indices in ascending order; all of them for "". Errors: as above, invalidArgument where FIRST or LAST is
/// not a step of the run.
Result<std::vector<std::size_t>> selectSteps(std::string_view text, std::size_t available);

/// Of a run that is still written, by a range whose form is right: whether it means this step, and the last
/// one that it means; none: all that come.
bool meansStep(std::string_view text, std::size_t step);
std::optional<std::size_t> lastStepMeant(std::string_view text);

}  // namespace mote
