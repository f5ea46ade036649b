// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/rank_frame.h"

#include "server/render/cpu/flat_picture.h"
#include "server/render/cpu/lone_points.h"
#include "server/render/ranks/count_sum.h"
#include "server/render/ranks/leaf_deal.h"
#include "server/render/ranks/mixed_frame.h"
#include "server/render/ranks/stop_relay.h"

namespace mote::render {
namespace {

/// Of points where depth does not matter, a picture is the sum of everyone's counts.
std::optional<Picture> drawFlat(Ranks& ranks, RankParts& parts, const FrameOrder& order, Agreement& agreement,
                                const std::stop_token& stop) {
    agreement.attempt([&] {
        const LayerPlan& layer = order.plan.layers[*order.flatLayer];
        const StopRelay relay(ranks, order.number, stop);
        parts.arena.execute([&] {
            const auto cells = parts.leaves.of(layer.step).upTo(*layer.step, layer.selection->drawn.size());
            parts.flat.draw(order.plan, layer, cells, relay.token());
        });
        layer.step->check();
    });
    if (!agreement.all(stop)) return std::nullopt;
    addUpCounts(ranks, parts.flat.counts());
    const auto drawn = ranks.sum(parts.flat.pointsDrawn());
    if (ranks.rank() != 0) return std::nullopt;
    auto picture = parts.arena.execute([&] {
        return flatPicture(order.plan, order.plan.layers[*order.flatLayer], parts.flat, order.format);
    });
    picture.pointsDrawn = drawn;
    return picture;
}

}  // namespace

void keepOwnPoints(FrameOrder& order, const Ranks& ranks) {
    for (auto& layer : order.plan.layers) {
        const std::size_t leaves = layer.selection->drawn.size();
        const bool alone = !order.flatLayer && standAlone(order.plan, layer);
        if (leaves == 0 || alone) continue;
        const LeafDeal deal(layer.step->leaves().size(), ranks.size());
        layer.leavesInView = deal.own(layer.leavesInView, leaves, ranks.rank());
    }
}

std::optional<Picture> drawTogether(Ranks& ranks, RankParts& parts, const FrameOrder& order,
                                    Agreement& agreement, const std::stop_token& stop) {
    if (order.flatLayer) return drawFlat(ranks, parts, order, agreement, stop);
    return MixedFrame(ranks, parts, order, agreement, stop).draw();
}

}  // namespace mote::render
