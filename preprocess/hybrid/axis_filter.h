// SPDX-License-Identifier: GPL-3.0-or-later
//
// AxisFilter: which samples of the source make a sample of the low-resolution volume, along one axis, and
// with which weights. A value.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/hybrid/volume_plan.h"

namespace mote::prep {

class AxisFilter {
  public:
    /// Filters `samples` of the source to `low` of them, low <= samples. Box: by how much of a sample's cell
    /// each covers. Cubic (also for `under`): Keys' kernel with a = -1/2 (Keys 1981, Cubic convolution
    /// interpolation), stretched to the spacing of the low samples, so that nothing is skipped; what lies
    /// beyond the ends has no weight. Weights add up to 1.
    AxisFilter(LowFilter filter, std::uint32_t samples, std::uint32_t low);

    std::uint32_t size() const { return static_cast<std::uint32_t>(taps_.size()); }
    /// Samples [first, end) of the source make sample j.
    std::uint32_t first(std::uint32_t j) const { return taps_[j].first; }
    std::uint32_t end(std::uint32_t j) const { return taps_[j].first + taps_[j].count; }
    std::span<const float> weights(std::uint32_t j) const {
        return std::span(weights_).subspan(taps_[j].begin, taps_[j].count);
    }

  private:
    struct Taps {
        std::uint32_t first, count;
        std::size_t begin;  ///< in weights_
    };
    std::vector<Taps> taps_;
    std::vector<float> weights_;
};

}  // namespace mote::prep
