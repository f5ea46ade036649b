// SPDX-License-Identifier: GPL-3.0-or-later
//
// One picture, drawn by all ranks: each adds up the points of its own leaves; where depth matters, it sends
// their cells to the owners of the tiles, who composite them with the volumes, which every rank has. Sums do
// not depend on which rank's points lie in front: no order of the ranks is needed. All ranks call it alike.
#pragma once

#include <optional>
#include <stop_token>

#include "server/render/ranks/agreement.h"
#include "server/render/ranks/frame_order.h"
#include "server/render/ranks/rank_parts.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {

/// Leaves in the order's plan what this rank draws of it; of points that stand alone, all.
void keepOwnPoints(FrameOrder& order, const Ranks& ranks);

/// The picture on rank 0, or nothing where `agreement` did not go on; nothing on the others. `order`: with
/// the rank's own steps and leaves, unless something failed before, which `agreement` knows.
std::optional<Picture> drawTogether(Ranks& ranks, RankParts& parts, const FrameOrder& order,
                                    Agreement& agreement, const std::stop_token& stop);

}  // namespace mote::render
