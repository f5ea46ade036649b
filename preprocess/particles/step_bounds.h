// SPDX-License-Identifier: GPL-3.0-or-later
//
// The ranges of a step's plot coordinates by the rule of bounds_rule.h, found block by block.
#pragma once

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/step_reader.h"

namespace mote::prep {

/// One pass, and another one or two where particles are left out. Empty ranges for a step without particles.
/// The same on all ranks, for any number of them. Errors: the source's own, cancelled.
Result<std::array<Range, 3>> stepBounds(StepReader& reader, Communicator& ranks);

}  // namespace mote::prep
