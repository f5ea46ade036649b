// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/selection_cache.h"

#include "protocol/scene/most_recent.h"

namespace mote::render {

std::shared_ptr<const PointSelection> SelectionCache::of(
    const std::shared_ptr<const storage::ParticleStep>& step, const Curve& pointFraction, double share) {
    entries_.remove_if([](const Entry& entry) { return entry.step.expired(); });
    const auto* const known = mostRecent(entries_, [&](const Entry& entry) {
        return entry.step.lock() == step && entry.share == share && entry.pointFraction == pointFraction;
    });
    if (known != nullptr) return known->selection;
    // Selections are large: the oldest goes before the new one comes.
    while (entries_.size() >= kept) entries_.pop_back();
    auto selection = std::make_shared<const PointSelection>(selectPoints(*step, pointFraction, share));
    entries_.push_front({step, pointFraction, share, selection});
    return selection;
}

}  // namespace mote::render
