// SPDX-License-Identifier: GPL-3.0-or-later
//
// SlabWindow: the slices of a source that are in memory, a window that moves in ascending z and reads each
// slice once. What is not finite becomes the least value. One owner; slices may be read from any thread
// between moves.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/volume/volume_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

class SlabWindow {
  public:
    /// `source` must outlive this. `least` takes the place of values that are not finite.
    SlabWindow(VolumeSource& source, double least)
        : source_(source), least_(static_cast<float>(least)), slice_(source.shape().voxelsOfSlice()) {}

    /// Makes slices [z0, z1) the window; neither end may lie before the last one's. Errors: the source's.
    Status cover(std::uint32_t z0, std::uint32_t z1);

    std::uint32_t begin() const { return begin_; }
    std::uint32_t end() const { return end_; }
    /// A slice of the window, x fastest.
    std::span<const float> slice(std::uint32_t z) const {
        return std::span(values_).subspan((z - begin_) * slice_, slice_);
    }

  private:
    VolumeSource& source_;
    float least_;
    std::size_t slice_;  ///< values of one
    std::uint32_t begin_ = 0, end_ = 0;
    std::vector<float> values_;
};

}  // namespace mote::prep
