// SPDX-License-Identifier: GPL-3.0-or-later
//
// Statistics of a step's points (storage/beam/beam_statistics.h) from the columns beside them, of all or of
// some, and of slices along a quantity. Values and a function without state, which uses all threads of
// the calling arena; any number gives the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "storage/beam/beam_statistics.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

struct SlicesWanted {
    static constexpr std::uint32_t most = 256;

    std::string column;        ///< or derived quantity
    std::uint32_t count = 50;  ///< 1 to most
    /// Even slices, or slices that the same weight lies in (edgesOfEqualWeight()).
    enum class Of : std::uint8_t { even, charge } of = Of::even;
};

/// Percentiles take two passes more over all values than moments do; without slices mostly none if weights
/// are alike and one if not, and memory for a sample of half a million points and for what lies near cuts.
enum class Passes { momentsAlone, percentilesToo };

struct PointStatistics {
    std::vector<double> values;               ///< by statistics(), of percentiles that were left NaN; further
    std::vector<double> edges;                ///< of slices, one more than there are
    std::vector<std::vector<double>> slices;  ///< by slice; of each as `values`
};

/// Statistics of quantities that the table does not have.
using FurtherStatistics = std::span<const QuantityStatistic>;

/// `chosen`: these points alone; null: all. Slices span the chosen points' own range, and where all have one
/// value, half of a unit to both sides of it. Errors: notFound, at "slices"; cancelled. Throws StorageError.
Result<PointStatistics> pointStatistics(const StepNumbers& step, const BeamFacts& facts,
                                        const PointMask* chosen, const std::optional<SlicesWanted>& slices,
                                        Passes passes, const std::function<bool()>& cancelled,
                                        FurtherStatistics further = {});

}  // namespace mote::storage
