// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is seen of each kind of data that an ink layer draws: the one place that asks for a kind
// (docs/INK.md, "What is seen" and "Lines"). Pure; many threads work at it.
#pragma once

#include <stop_token>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/drawing.h"
#include "server/render/layers/ink/ink_data.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// The 3D stage; its lines only where they are asked for. `plan`: its size and its camera are told, and
/// whether it is exact. Where `stop` is requested meanwhile something is missing.
InkScene seenOf(const InkData& data, const glm::dmat4& transform, const InkStyle& style,
                const FramePlan& plan, bool lines, const std::stop_token& stop);

}  // namespace mote::render
