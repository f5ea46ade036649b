// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameOrder: what rank 0 asks all ranks to draw: a frame plan without what each rank finds in its own copy
// of the steps, their data and their selections. A value; pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/render/picture.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/ranks/rank_steps.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {

struct FrameOrder {
    std::uint64_t number = 0;  ///< of the picture
    PixelFormat format = PixelFormat::srgb8;
    std::optional<std::uint32_t> flatLayer;  ///< the only layer, where depth does not matter
    std::vector<RankSteps::Name> steps;      ///< one a layer of particles
    /// A hybrid layer: what its plan is made of, and its step.
    struct Hybrid {
        RankSteps::Name step;
        HybridStyle style;  ///< its representation is that of the plan
        glm::dmat4 layerToWorld;
    };
    std::vector<Hybrid> hybrids;
    FramePlan plan;
};

Bytes packOrder(const FrameOrder& order);

/// In the layers' plans `step` and `preview` are null; `selection` is null too, but for layers that draw no
/// points of leaves, which have an empty one. There are no plans of hybrid layers.
FrameOrder unpackOrder(const Bytes& bytes);

}  // namespace mote::render
