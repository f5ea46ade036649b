// SPDX-License-Identifier: GPL-3.0-or-later
//
// CpuPicture: a picture whose points and dots are sorted, on its way from tile to tile. As UnfinishedPicture.
// It has the device's lists for itself, and gives them back when it is done.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/cpu/cpu_parts.h"
#include "server/render/plan/unfinished_picture.h"

namespace mote::render {

class CpuPicture final : public UnfinishedPicture {
  public:
    /// Takes the sorted lists from the device's parts, which outlive its work. `colors`: of each of the
    /// plan's points.
    CpuPicture(CpuParts& parts, const FramePlan& plan, PixelFormat format, FrameColors colors);

    bool advance(const std::stop_token& pause) override;
    Picture take() override;
    std::uint64_t bytes() const override;

  private:
    bool drawTiles(const std::stop_token& pause);
    void drawTile(const CompositeFrame& frame, Tile tile);

    CpuParts& parts_;
    const FramePlan& plan_;
    const FrameColors colors_;
    FramePoints points_;
    FrameDots dots_;
    Picture picture_;
    std::vector<std::uint8_t> done_;  // tiles, row by row
    std::size_t left_;                // of them
    bool waited_ = false;             // since the points were verified
};

}  // namespace mote::render
