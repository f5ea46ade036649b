// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/selection_cache.h"
#include "server/render/ranks/rank_frame.h"
#include "server/render/ranks/ranked_device.h"

namespace mote::render {
namespace {

/// Gives the layers of an order the rank's own steps, and the same selections of them as rank 0 has.
void complete(FrameOrder& order, RankSteps& steps, SelectionCache& selections) {
    for (std::size_t i = 0; i < order.steps.size(); ++i) {
        auto step = steps.open(order.steps[i]);
        if (!step.ok()) throw storage::StorageError(step.error());
        LayerPlan& layer = order.plan.layers[i];
        layer.step = *std::move(step);
        if (layer.selection == nullptr) {
            layer.selection = selections.of(layer.step, layer.style.pointFraction, layer.share);
        }
    }
    for (const auto& layer : order.hybrids) {
        auto step = steps.openHybrid(layer.step, layer.style.representation);
        if (!step.ok()) throw storage::StorageError(step.error());
        order.plan.hybrids.push_back(
            planHybrid(layer.style, layer.layerToWorld, *std::move(step), order.plan.camera));
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
