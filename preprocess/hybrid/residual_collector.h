// SPDX-License-Identifier: GPL-3.0-or-later
//
// Residual bricks from an error pass: errors as multiples of a step, encoded. Functions on the caller's
// oneTBB threads.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/hybrid/error_pass.h"
#include "preprocess/hybrid/value_range.h"
#include "storage/hybrid/residual_encoder.h"

namespace mote::prep {

/// The step for errors above `threshold`, in the source's unit: what is left of an error is half a step at
/// most, and that shall be no more than the threshold below which errors are left as they are. So it is the
/// greatest power of two up to twice the threshold (as a half, a multiple then has few bits, which compress
/// well), but no less than the source's own quantum: a power of two up to `valueStep` (VolumeShape); where
/// that is not known, 1 if all values are integers, else 2^-16 of their span; and 2^-19 of it in any case.
double residualStep(const ValueRange& range, double valueStep, double threshold);

/// The bricks of a slab that begins at a multiple of their side, and lies in one layer of OpenVDB's nodes,
/// put aside; in no order. Errors: as ScratchFile::append.
Result<std::vector<storage::ResidualPart>> residualParts(const ErrorSlab& slab,
                                                         const ErrorSelection& selection,
                                                         const storage::ResidualCoding& coding,
                                                         storage::ScratchFile& scratch);

}  // namespace mote::prep
