// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameOrder: what rank 0 asks all ranks to draw: a frame plan without what each rank finds in its own copy
// of the steps, their data and their selections. A value; pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/render/plan/frame_plan.h"
#include "server/render/plan/picture.h"
#include "server/render/plan/pixel_colors.h"
#include "server/render/ranks/rank_steps.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {

struct FrameOrder {
    std::uint64_t number = 0;  ///< of the picture
    PixelFormat format = PixelFormat::srgb8;
    std::optional<std::uint32_t> flatPoints;  ///< the only ones, if depth does not matter
    std::vector<RankSteps::Name> pointSteps;  ///< one of the plan's points each
    std::vector<RankSteps::Name> fieldSteps;  ///< one of its fields each
    FramePlan plan;
    FrameColors colors;  ///< one of the plan's points each
};

Bytes packOrder(const FrameOrder& order);

/// In the plan nothing has its data. `selection` is null too, but for points that are of no leaves, which
/// have an empty one.
FrameOrder unpackOrder(std::span<const std::byte> bytes);

}  // namespace mote::render
