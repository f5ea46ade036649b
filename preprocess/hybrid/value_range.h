// SPDX-License-Identifier: GPL-3.0-or-later
//
// What values a volume has. Functions without state; they work on the caller's oneTBB threads.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::prep {

struct ValueRange {
    double min = 0.0, max = 0.0;  ///< of the finite values; 0 if there is none
    std::uint64_t finite = 0;     ///< samples
    std::uint64_t invalid = 0;    ///< samples that are not finite
    bool integers = true;         ///< all finite values are

    double span() const { return max - min; }
    ValueRange united(const ValueRange& other) const;
};

/// The range of slices [z0, z1), `together` at a time. `cancelled` is asked between. Errors: the source's,
/// cancelled.
Result<ValueRange> findRange(VolumeSource& source, std::uint32_t z0, std::uint32_t z1, std::uint32_t together,
                             const std::function<bool()>& cancelled);

using ValueHistogram = std::array<std::uint64_t, storage::valueHistogramBins>;

/// Adds values, all of them in the range, to even bins over it.
void addToHistogram(std::span<const float> values, const ValueRange& range, ValueHistogram& histogram);

}  // namespace mote::prep
