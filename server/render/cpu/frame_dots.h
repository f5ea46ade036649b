// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameDots: the dots of one picture, sorted by the tiles that they touch and by depth; with them, points
// that stand alone. Owned by the device, its memory reused from picture to picture.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "server/render/cpu/tile_dots.h"
#include "server/render/cpu/tile_points.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/tile_lists.h"

namespace mote::render {

class FrameDots {
  public:
    /// In turns (plan/in_turns.h), on all threads of the calling arena. Stops early where `stop` is
    /// requested. What the plan's surfaces and strokes are is made tile by tile.
    void sort(const FramePlan& plan, const std::stop_token& stop);

    /// A tile's dots with its points that stand alone; null where it has neither. It belongs to the calling
    /// thread until it asks again. Throws std::bad_alloc.
    const TileDots* of(Tile tile, const FramePoints& points);

    /// What it made of a plan goes; the room of lists stays.
    void forget() { makers_.clear(); }

    /// In memory, about.
    std::uint64_t bytes() const {
        return placed_.dots.capacity() * sizeof(ScreenDot) + placed_.depths.capacity() * sizeof(double) +
               tiles_.bytes();
    }

  private:
    struct Local {
        std::vector<LonePoint> points;
        PlacedDots made;  // where it is drawn
        std::vector<std::pair<double, const ScreenDot*>> placed;
        std::vector<TileDot> all;
        TileDots tile;
    };
    void make(Tile tile, Local& local) const;

    std::uint32_t slabs_ = 0;
    std::uint32_t width_ = 0, height_ = 0;
    std::uint32_t columns_ = 0;  // of tiles
    std::vector<DepthSection> sections_;
    std::vector<std::shared_ptr<const FragmentMaker>> makers_;
    PlacedDots placed_;
    TileLists<std::uint32_t> tiles_;  // indices into them, front to back
    tbb::enumerable_thread_specific<Local> local_;
};

}  // namespace mote::render
