// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/selection_cache.h"

#include "protocol/scene/most_recent.h"

namespace mote::render {

std::shared_ptr<const PointSelection> SelectionCache::of(const Step& step, const PointChoice& choice) {
    entries_.remove_if([](const Entry& entry) { return entry.step.expired(); });
    const auto* const known = mostRecent(
        entries_, [&](const Entry& entry) { return entry.step.lock() == step && entry.choice == choice; });
    if (known != nullptr) return known->selection;
    // Selections are large: the oldest goes before the new one comes.
    while (entries_.size() >= kept) entries_.pop_back();
    auto selection = std::make_shared<const PointSelection>(selectPoints(*step, choice));
    entries_.push_front({step, choice, selection});
    return selection;
}

std::shared_ptr<const StepVolume> SelectionCache::volume(const Step& step, const TransferFunction& transfer,
                                                         bool rough) {
    volumes_.remove_if([](const Volume& volume) { return volume.step.expired(); });
    const auto* const known = mostRecent(volumes_, [&](const Volume& volume) {
        return volume.step.lock() == step && volume.rough == rough && volume.opacity == transfer.opacity;
    });
    if (known != nullptr) return known->grid;
    // Which layers a picture has is bounded, and so is how many of them are kept.
    while (volumes_.size() >= keptVolumes) volumes_.pop_back();
    auto made = rough ? roughStepVolume(*step, transfer) : stepVolume(*step, transfer);
    auto grid = made.empty() ? nullptr : std::make_shared<const StepVolume>(std::move(made));
    volumes_.push_front({step, transfer.opacity, rough, grid});
    return grid;
}

}  // namespace mote::render
