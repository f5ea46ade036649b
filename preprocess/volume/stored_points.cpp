// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/stored_points.h"

#include <utility>

namespace mote::prep {

StoredPoints::StoredPoints(CollectedPoints points, const storage::GridSize& grid, std::uint32_t bytes)
    : grid_(grid), points_(std::move(points)) {
    brickBegin_.push_back(0);
    for (const auto count : points_.brickCount) brickBegin_.push_back(brickBegin_.back() + count);
    if (bytes == 5) return;
    view().forEach([&](const storage::HybridPoint& point) {
        for (const auto coordinate : point.place) {
            if (bytes == 6) place8_.push_back(static_cast<std::uint8_t>(coordinate));
            if (bytes == 9) place16_.push_back(static_cast<std::uint16_t>(coordinate));
        }
    });
    brickBegin_.clear();
    points_.place.clear();
}

storage::HybridPoints StoredPoints::view() const {
    return {grid_,    brickBegin_,   points_.place, place8_,
            place16_, points_.value, points_.error, points_.normal};
}

}  // namespace mote::prep
