// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whether a table of numbers can be a particle file of IMPACT-Z: nine columns without names are common, and
// read as the wrong nine they make a beam that never was. A function without state.
#pragma once

#include "preprocess/readers/impact/number_table.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Looks at the first rows: numbers of particles are whole, charges over masses those of `mass` (eV/c^2),
/// phases those of a bunch, and most energies carry their transverse momenta, where `gamma` of the reference
/// particle is known (else 0). Leaves `table` closed. Errors: unsupported, corrupt.
Status checkImpactZ(NumberTable& table, double mass, double gamma, Progress& progress);

}  // namespace mote::prep
