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
    /// and 0.
    std::vector<std::uint64_t> words;

    /// The same of other points.
    void add(const ValueSums& others);
};

/// Nothing where `stop` was requested meanwhile. `cells`: of the leaves that are drawn. Throws
/// storage::StorageError.
std::optional<ValueSums> valueSums(const FramePlan& plan, const PointsPlan& points,
                                   std::span<const LeafCell> cells, const std::stop_token& stop);

/// The colours of a layer's points, which have colours.
PixelColors pixelColors(const FramePlan& plan, const PointsPlan& points, const ValueSums& sums);

/// Nothing where `stop` was requested meanwhile. Throws storage::StorageError.
std::optional<FrameColors> frameColors(const FramePlan& plan, ResidentLeaves& leaves,
                                       const std::stop_token& stop);

}  // namespace mote::render
