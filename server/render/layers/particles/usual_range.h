// SPDX-License-Identifier: GPL-3.0-or-later
//
// usualRange: what the colours of a column stand for if a view does not say it (docs/PICTURE.md, "Colour
// by a column"). As point_data.h: a pure function that uses all threads of the calling arena.
#pragma once

#include <functional>
#include <string>

#include "protocol/base/error.h"
#include "protocol/scene/transfer_function.h"
#include "storage/numbers/run_steps.h"

namespace mote::render {

/// What is looked at of a run: the same of the same run, always.
struct RangeSample {
    static constexpr std::uint32_t steps = 32;    ///< at most, evenly strided
    static constexpr std::uint64_t block = 1024;  ///< points that follow each other
    static constexpr std::uint64_t blocks =
        2048;                                    ///< of all steps, evenly strided, at most; but of each step
    static constexpr std::uint64_t fewest = 64;  ///< so many if there are as many, and
    static constexpr std::uint64_t greatest = 256;  ///< at most so many
    /// That are held while a range is found, at most.
    static constexpr std::uint64_t bytes() { return (blocks + steps) * block * 2 * sizeof(double); }
};

/// The two finite values of a column or derived quantity below and above which one hundredth each of the
/// weight of all steps lies, as a RangeSample tells: of up to 65,536 points a step, and 2^21 in all, all are
/// looked at. If the two are one value, the least and the greatest of all; 0 and 0 if there is none.
/// Errors: notFound, at "column"; cancelled. Throws storage::StorageError.
Result<ValueRange> usualRange(const storage::RunSteps& run, const std::string& column,
                              const std::function<bool()>& cancelled);

}  // namespace mote::render
