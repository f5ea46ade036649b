// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lowering: what a kind of layer is given to become primitives, and where it puts them. Made for one plan by
// make_frame_plan.h; one thread.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "protocol/scene/bounds.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/quality.h"
#include "server/render/plan/selection_cache.h"

namespace mote::render {

struct Lowering {
    FramePlan& plan;  ///< its size and its camera are told
    const Quality& quality;
    SelectionCache& selections;
    DeviceAbilities device;
    Reading reading;
    double pixels;                     ///< of the plan, a pixel of the view
    std::uint32_t slabs;               ///< that each layer is cut into
    std::stop_token stop;              ///< what is lowered after a request is of no use
    std::vector<DepthRange> depths{};  ///< where something lies
    /// What of points takes long: done before `last`, as points lie before surfaces of their depth.
    std::vector<std::function<void()>> highlights{};
    /// What takes long and reads nothing: done after all else, and not for a picture that waits for data.
    std::vector<std::function<void()>> last{};

    /// Something lies in a box of eye space.
    void addBox(const Bounds& inEye);
    /// Something stands at depths of its own between two: no slabs are needed for it.
    void addDots(double nearest, double farthest);
};

/// A field of a layer of that opacity: its extinction times it (docs/PICTURE.md, "Layers that fade").
TransferFunction thinned(TransferFunction transfer, double opacity);

}  // namespace mote::render
