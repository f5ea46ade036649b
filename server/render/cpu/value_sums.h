// SPDX-License-Identifier: GPL-3.0-or-later
//
// ValueSums: what is found of the colours of pixels (plan/pixel_colors.h) from some points of a layer; sums
// of parts are those of the whole, to the bit. Values; functions use all threads of the calling arena, in
// turns (plan/in_turns.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "server/render/cpu/leaf_cells.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/pixel_colors.h"

namespace mote::render {

struct ValueSums {
    bool nearest = false;
    /// Two words a pixel, row by row: the weight of its points that have a value, and the sum of weights
    /// times codes. Nearest: the least of depths with codes in their low bits, all ones where there is none;
    /// and, where they are counted, how many points it holds, of full pixels (FullCount) perhaps less.
    std::vector<std::uint64_t> words;
    std::uint64_t counted = 0;  ///< points, of nearest ones that are

    /// The same of other points.
    void add(const ValueSums& others);
};

/// Nothing where `stop` was requested meanwhile. `cells`: of the leaves that are drawn. `count`: nearest ones
/// of at most a pixel are counted, too, as the picture of these points alone needs it. Throws
/// storage::StorageError.
std::optional<ValueSums> valueSums(const FramePlan& plan, const PointsPlan& points,
                                   std::span<const LeafCell> cells, const std::stop_token& stop,
                                   bool count = false);

/// The colours of a layer's points, which have colours.
PixelColors pixelColors(const FramePlan& plan, const PointsPlan& points, const ValueSums& sums);

struct ColorSearch {
    bool count = false;           ///< as of valueSums
    bool cellsAreShaded = false;  ///< layers for which shadesCells() holds are left out
};

/// Nothing where `stop` was requested meanwhile. Throws storage::StorageError.
std::optional<FrameColors> frameColors(const FramePlan& plan, ResidentLeaves& leaves,
                                       const std::stop_token& stop, ColorSearch search = {});

}  // namespace mote::render
