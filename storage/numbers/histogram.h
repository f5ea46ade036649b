// SPDX-License-Identifier: GPL-3.0-or-later
//
// Histograms of quantities of a step's points, at full data: docs/SELECTIONS.md, "Histograms". Values and
// functions without state, which use all threads of the calling arena; any number gives the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

struct HistogramAxis {
    std::string column;        ///< or derived quantity
    std::uint32_t bins = 100;  ///< 1 to mostBins
    double low = 0.0;          ///< finite, below high
    double high = 1.0;

    static constexpr std::uint32_t mostBins = 4096;
};

struct Histogram {
    std::vector<std::vector<double>> edges;  ///< by axis; one more than bins
    std::vector<double> counts;              ///< weight by bin, of the second axis fastest
    std::uint64_t particles = 0;             ///< that it rests on
    double outside = 0.0;                    ///< weight of those beyond a range, or not a number
};

/// One axis or two. `chosen`: these points alone; null: all. Unweighted, a point counts 1. Errors: notFound
/// at "axes[1].column"; cancelled. Throws StorageError.
Result<Histogram> countHistogram(const std::vector<HistogramAxis>& axes, bool unweighted,
                                 const StepNumbers& step, const PointMask* chosen,
                                 const std::function<bool()>& cancelled);

/// Numbers of points by the scaled log density of their leaf, 0 to 1; the axis' column does not count.
/// `chosen` as above. Throws StorageError.
Histogram countLeafDensities(const HistogramAxis& axis, const ParticleStep& step, const PointMask* chosen);

/// Bytes that countHistogram takes while it counts.
std::uint64_t histogramBytes(const std::vector<HistogramAxis>& axes);

}  // namespace mote::storage
