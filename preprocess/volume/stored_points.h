// SPDX-License-Identifier: GPL-3.0-or-later
//
// StoredPoints: collected points in one of the forms that they have on disk. A value.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/volume/point_collector.h"
#include "storage/hybrid/hybrid_points.h"

namespace mote::prep {

class StoredPoints {
  public:
    /// `bytes` is 5, 6 or 9; `points` are those of all bricks of the grid.
    StoredPoints(CollectedPoints points, const storage::GridSize& grid, std::uint32_t bytes);

    /// Good as long as this is.
    storage::HybridPoints view() const;

  private:
    storage::GridSize grid_;
    CollectedPoints points_;
    std::vector<std::uint64_t> brickBegin_;
    std::vector<std::uint8_t> place8_;
    std::vector<std::uint16_t> place16_;
};

}  // namespace mote::prep
