// SPDX-License-Identifier: GPL-3.0-or-later
//
// FloatBins: bins of a column as it is stored: their edges become floats, so that no value is turned into a
// double and none lands elsewhere than the double would. Vectorised for the processor at hand, with the same
// result on all. Immutable; any number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace mote::storage {

class FloatBins {
  public:
    /// (float - low) * scale is about the bin of a float from `first` to `last`, to within `doubt`; others
    /// have none.
    struct Guess {
        float first = 0.0F, last = -1.0F;
        float low = 0.0F, scale = 0.0F;
        float doubt = 1.0F;
        std::uint32_t bins = 0;
    };

    FloatBins() = default;
    /// Ascending edges of bins of equal width, but for rounding, of the value offset + float.
    FloatBins(double offset, std::span<const double> edges);

    /// The bin of each; as many as there are bins where it has none.
    void find(std::span<const float> values, std::span<std::uint32_t> out) const;

  private:
    std::vector<float> begins_;  ///< of each bin, its least float; then the least beyond the last
    Guess guess_;
};

}  // namespace mote::storage
