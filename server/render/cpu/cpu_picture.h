// SPDX-License-Identifier: GPL-3.0-or-later
//
// CpuPicture: a picture on its way: prepared, which is counting colours and sorting points and dots by tiles,
// and then drawn from tile to tile. As UnfinishedPicture. Its preparation is work in turns
// (plan/work_in_turns.h). It has the device's lists for itself until it is done or given up.
#pragma once

#include <oneapi/tbb/task_arena.h>

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "server/render/cpu/cpu_parts.h"
#include "server/render/plan/unfinished_picture.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {

class CpuPicture final : public UnfinishedPicture {
  public:
    /// Nothing is done yet. The parts outlive its work. `leastTurn`: as WorkInTurns.
    CpuPicture(CpuParts& parts, const FramePlan& plan, PixelFormat format, WorkInTurns::Duration leastTurn);

    /// All of it at once. False where `stop` was requested before it was done. Throws what advance() throws.
    bool draw(const std::stop_token& stop);
    bool advance(const std::stop_token& pause) override;
    Picture take() override;
    std::uint64_t bytes() const override;
    void giveUp() override;

  private:
    void borrowLists();
    void giveListsBack();
    bool prepareInTurns(const std::stop_token& pause);
    bool prepare(const std::stop_token& stop);
    bool drawFlat(const PointsPlan& only, const PixelColors* colors, const std::stop_token& stop);
    void beginTiles();
    bool drawTiles(const std::stop_token& pause);
    void drawTile(const CompositeFrame& frame, Tile tile);

    CpuParts& parts_;
    const FramePlan& plan_;
    const WorkInTurns::Duration leastTurn_;
    FrameColors colors_;  // of each of the plan's points
    FramePoints points_;
    FrameDots dots_;
    FlatPoints flat_;
    Picture picture_;
    std::vector<std::uint8_t> done_;  // tiles, row by row
    std::size_t left_ = 0;            // of them
    bool prepared_ = false;
    bool waited_ = false;              // since the points were verified
    oneapi::tbb::task_arena turns_;    // of the preparation alone: who waits in an arena keeps a place of it
    std::optional<WorkInTurns> work_;  // goes first: it uses the others
};

}  // namespace mote::render
