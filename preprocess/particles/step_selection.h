// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which steps of a run a job takes: "FIRST:LAST:STRIDE" of the run's step indices, last included. Pure
// functions.
#pragma once

#include <string_view>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::prep {

/// The form alone. Also "N", "FIRST:LAST"; an empty FIRST is 0, an empty LAST the run's last step. Errors:
/// invalidArgument.
Status checkStepSelection(std::string_view text);

/// Indices in ascending order; all of them for "". Errors: as above, invalidArgument where FIRST or LAST is
/// not a step of the run.
Result<std::vector<std::size_t>> selectSteps(std::string_view text, std::size_t available);

}  // namespace mote::prep
