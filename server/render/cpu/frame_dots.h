// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameDots: the dots of one picture and the points of its hybrid volumes, sorted by the tiles that they
// touch. Owned by the device, its memory reused from picture to picture.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <stop_token>
#include <vector>

#include "server/render/cpu/tile_dots.h"
#include "server/render/cpu/tile_lists.h"
#include "server/render/frame_plan.h"

namespace mote::render {

class FrameDots {
  public:
    /// Uses all threads of the calling arena. Stops early where `stop` is requested.
    void sort(const FramePlan& plan, const std::stop_token& stop);

    /// Null where a tile has no dots. It belongs to the calling thread until it asks again.
    const TileDots* of(Tile tile);
    /// Points of hybrid volumes.
    std::uint64_t splatsDrawn() const { return splats_; }

  private:
    std::uint32_t slabs_ = 0;
    std::uint32_t columns_ = 0;    // of tiles
    std::vector<ScreenDot> dots_;  // front to back, then the points
    std::uint64_t splats_ = 0;
    std::vector<KeptPointLooks> looks_;  // of the hybrid layers
    TileLists<std::uint32_t> tiles_;     // indices into them
    struct Local {
        std::vector<std::uint64_t> keys;
        std::vector<std::uint32_t> own;  // front to back
        TileDots dots;
    };
    tbb::enumerable_thread_specific<Local> local_;
};

}  // namespace mote::render
