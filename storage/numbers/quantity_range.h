// SPDX-License-Identifier: GPL-3.0-or-later
//
// The range of a column or derived quantity over all steps of a run. A function without state; uses all
// threads of the calling arena.
#pragma once

#include <functional>
#include <string>

#include "protocol/base/error.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

struct QuantityRange {
    double low = 0.0, high = 0.0;  ///< of its finite values; low > high where there is none
};

/// Of a column the manifest knows it, of a quantity where it has statistics "min_" and "max_" of it; else all
/// steps are read. Errors, at the name: notFound; cancelled; corrupt.
Result<QuantityRange> quantityRange(const RunSteps& run, const std::string& name,
                                    const std::function<bool()>& cancelled);

}  // namespace mote::storage
