// SPDX-License-Identifier: GPL-3.0-or-later
//
// FlatPoints: the points of a layer where depth does not matter, since nothing else is in the picture: how
// much of them each pixel holds. Owned by the device, its memory reused from picture to picture; one thread,
// which uses all threads of the calling arena, in turns (plan/in_turns.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "server/render/cpu/leaf_cells.h"
#include "server/render/cpu/point_map.h"
#include "server/render/cpu/point_stream.h"
#include "server/render/cpu/points_kernel.h"
#include "server/render/cpu/resident_fields.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/picture.h"
#include "server/render/plan/pixel_colors.h"

namespace mote::render {

/// How many points of a look, of at most a pixel, hide what is behind them, whatever its colour.
FullCount fullOfAnyColor(const PointLook& look);

class FlatPoints {
  public:
    /// Draws what the plan selects, for a picture of a format whose points have `colors`, as flatPicture
    /// makes it: what is not seen behind a full pixel may not be counted. False where `stop` was requested
    /// meanwhile. Throws storage::StorageError.
    bool draw(const FramePlan& plan, const PointsPlan& layer, std::span<const LeafCell> cells,
              const PixelColors* colors, PixelFormat format, const std::stop_token& stop);

    /// In place of draw(): what else has counted them, points of at most a pixel. `drawn`: how many they are;
    /// 0: the sum.
    void take(std::span<const std::uint32_t> counts, std::uint64_t drawn = 0);

    /// Optical depth of a count over that of one point: 1, or what discs, which cover pixels in part, are
    /// counted by.
    double weightOfOne() const { return weightOfOne_; }
    /// Each pixel's count, row by row; valid until the next draw().
    std::span<const std::uint32_t> counts() const { return {counts_.data(), pixels_}; }
    /// The same, to add what others counted.
    std::span<std::uint32_t> counts() { return {counts_.data(), pixels_}; }
    std::uint64_t pointsDrawn() const { return pointsDrawn_; }
    /// In memory, about.
    std::uint64_t bytes() const { return (parts_.size() + 1) * counts_.capacity() * sizeof(std::uint32_t); }

  private:
    std::size_t pixels_ = 0;
    std::vector<std::uint32_t> counts_;              // spareCounts longer
    std::vector<std::vector<std::uint32_t>> parts_;  // of the other threads, as long
    PointStream stream_;
    double weightOfOne_ = 1.0;
    std::uint64_t pointsDrawn_ = 0;
};

/// Which points are the only thing that is drawn, where points of one look are: depth does not matter then.
/// `fields`: one of the plan's each.
std::optional<std::uint32_t> flatPoints(const FramePlan& plan, const std::vector<VisibleField>& fields);

/// n points of opacity a leave (1 - a)^n of the background. `colors`: of the points by pixel; null: they have
/// one. Uses all threads of the calling arena, in turns.
Picture flatPicture(const FramePlan& plan, const PointsPlan& only, const FlatPoints& points,
                    const PixelColors* colors, PixelFormat format);

}  // namespace mote::render
