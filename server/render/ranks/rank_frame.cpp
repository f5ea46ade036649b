// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/rank_frame.h"

#include "server/render/cpu/flat_picture.h"
#include "server/render/cpu/lone_points.h"
#include "server/render/ranks/count_sum.h"
#include "server/render/ranks/leaf_distribution.h"
#include "server/render/ranks/mixed_frame.h"
#include "server/render/ranks/stop_relay.h"

namespace mote::render {
namespace {

/// A picture of points where depth does not matter is the sum of everyone's counts.
std::optional<Picture> drawFlat(Ranks& ranks, RankParts& parts, const FrameOrder& order, Agreement& agreement,
                                const std::stop_token& stop) {
    agreement.attempt([&] {
        const PointsPlan& only = order.plan.points[*order.flatPoints];
        const StopRelay relay(ranks, order.number, stop);
        parts.arena.execute([&] {
            const auto cells = parts.leaves.of(only.step).upTo(*only.step, only.selection->drawn.size());
            parts.flat.draw(order.plan, only, cells, relay.token());
        });
        only.step->check();
    });
    if (!agreement.all(stop)) return std::nullopt;
    addUpCounts(ranks, parts.flat.counts());
    const auto drawn = ranks.sum(parts.flat.pointsDrawn());
    if (ranks.rank() != 0) return std::nullopt;
    auto picture = parts.arena.execute([&] {
        return flatPicture(order.plan, order.plan.points[*order.flatPoints], parts.flat, order.format);
    });
    picture.pointsDrawn = drawn;
    return picture;
}

}  // namespace

void keepOwnPoints(FrameOrder& order, const Ranks& ranks) {
    for (auto& points : order.plan.points) {
        const std::size_t leaves = points.selection->drawn.size();
        const bool alone = !order.flatPoints && standAlone(order.plan, points);
        if (leaves == 0 || alone) continue;
        const LeafDistribution distribution(points.step->leaves().size(), ranks.size());
        points.leavesInView = distribution.own(points.leavesInView, leaves, ranks.rank());
    }
}

std::optional<Picture> drawTogether(Ranks& ranks, RankParts& parts, const FrameOrder& order,
                                    Agreement& agreement, const std::stop_token& stop) {
    if (order.flatPoints) return drawFlat(ranks, parts, order, agreement, stop);
    return MixedFrame(ranks, parts, order, agreement, stop).draw();
}

}  // namespace mote::render
