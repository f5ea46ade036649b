// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/selection_cache.h"
#include "server/render/ranks/rank_frame.h"
#include "server/render/ranks/ranked_device.h"

namespace mote::render {
namespace {

template <class Step>
Step held(Result<Step> step) {
    if (!step.ok()) throw storage::StorageError(step.error());
    return *std::move(step);
}

/// Gives an order's plan the rank's own data, and the same selections of them as rank 0 has.
void complete(FrameOrder& order, RankSteps& steps, SelectionCache& selections) {
    for (std::size_t i = 0; i < order.plan.points.size(); ++i) {
        PointsPlan& points = order.plan.points[i];
        points.step = held(steps.open(order.pointSteps[i]));
        if (points.selection == nullptr)
            points.selection = selections.of(points.step, points.fraction, points.share);
    }
    for (std::size_t i = 0; i < order.plan.fields.size(); ++i) {
        auto& samples = order.plan.fields[i].samples;
        if (auto* const cells = std::get_if<DensityField>(&samples)) {
            cells->step = held(steps.open(order.fieldSteps[i]));
        } else {
            std::get<CorrectedField>(samples).grid = held(steps.openGrid(order.fieldSteps[i]));
        }
    }
}

}  // namespace

void dismissRanks(Ranks& ranks) {
    Bytes nothing;
    ranks.broadcast(nothing);
}

void serveRanks(Ranks& ranks, RankSteps& steps, unsigned threads) {
    RankParts parts(threads);
    SelectionCache selections;
    std::uint64_t latest = 0;
    for (Bytes bytes;;) {
        ranks.broadcast(bytes);
        if (bytes.empty()) break;
        FrameOrder order = unpackOrder(bytes);
        latest = order.number;
        parts.dropExpired();
        steps.beginPicture();
        Agreement agreement(ranks);
        agreement.attempt([&] {
            parts.arena.execute([&] { complete(order, steps, selections); });
            keepOwnPoints(order, ranks);
        });
        drawTogether(ranks, parts, order, agreement, {});
    }
    // A stop that came too late is not left behind.
    ranks.stopArrived(latest);
}

}  // namespace mote::render
