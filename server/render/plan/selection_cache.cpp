// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/selection_cache.h"

#include "protocol/base/most_recent.h"
#include "server/render/plan/leaf_means.h"

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
                                                         const Curve& fraction, bool rough,
                                                         const std::shared_ptr<const PointValues>& values) {
    volumes_.remove_if([](const Volume& volume) { return volume.step.expired(); });
    const auto* const known = mostRecent(volumes_, [&](const Volume& volume) {
        return volume.step.lock() == step && volume.rough == rough && volume.opacity == transfer.opacity &&
               volume.fraction == fraction && volume.values == values;
    });
    if (known != nullptr) return known->grid;
    // Which layers a picture has is bounded, and so is how many of them are kept.
    while (volumes_.size() >= keptVolumes) volumes_.pop_back();
    auto made =
        rough ? roughStepVolume(*step, transfer) : stepVolume(*step, transfer, fraction, values.get());
    auto grid = made.empty() ? nullptr : std::make_shared<const StepVolume>(std::move(made));
    volumes_.push_front({step, transfer.opacity, fraction, rough, values, grid});
    return grid;
}

std::vector<storage::PointRange> SelectionCache::needed(const Step& step, const PointChoice& choice) {
    needed_.remove_if([](const Needed& one) { return one.step.expired(); });
    const auto* const known = mostRecent(needed_, [&](const Needed& one) {
        return one.step.lock() == step && one.fraction == choice.fraction && one.volume == choice.volume;
    });
    if (known != nullptr) return known->ranges;
    while (needed_.size() >= keptVolumes) needed_.pop_back();
    auto ranges = neededPoints(*step, choice);
    needed_.push_front({step, choice.fraction, choice.volume, ranges});
    return ranges;
}

StepWeight SelectionCache::weight(const Step& step, double meanWeight, bool rough) {
    if (!(meanWeight > 0.0)) return {};
    weights_.remove_if([](const Weight& one) { return one.step.expired(); });
    const auto* const known = mostRecent(weights_, [&](const Weight& one) {
        return one.step.lock() == step && one.meanWeight == meanWeight && one.rough == rough;
    });
    if (known != nullptr) return known->weight;
    while (weights_.size() >= keptVolumes) weights_.pop_back();
    const auto weight = rough ? roughStepWeight(*step, meanWeight) : stepWeight(*step, meanWeight);
    weights_.push_front({step, meanWeight, rough, weight});
    return weight;
}

std::shared_ptr<const PointValues> SelectionCache::leafMeans(
    const Step& step, const std::shared_ptr<const PointValues>& values) {
    means_.remove_if([](const Means& one) { return one.step.expired() || one.of.expired(); });
    const auto* const known = mostRecent(
        means_, [&](const Means& one) { return one.step.lock() == step && one.of.lock() == values; });
    if (known != nullptr) return known->means;
    while (means_.size() >= keptVolumes) means_.pop_back();
    auto means = std::make_shared<const PointValues>(render::leafMeans(*step, *values));
    means_.push_front({step, values, means});
    return means;
}

MovedPoints SelectionCache::moved(const Step& step, const std::shared_ptr<const PointSelection>& selection,
                                  const std::shared_ptr<const PointWays>& ways, double share,
                                  const std::shared_ptr<const PointValues>& values) {
    return this->moved({selection, ways, share, {}, values, {}},
                       [&] { return movePoints(*step, selection.get(), *ways, share, values.get()); });
}

MovedPoints SelectionCache::cut(const Step& step, const std::shared_ptr<const PointSelection>& selection,
                                const HalfSpaces& clips, const std::shared_ptr<const PointValues>& values) {
    return moved({selection, {}, 0.0, clips, values, {}},
                 [&] { return cutPoints(*step, selection.get(), clips, values.get()); });
}

template <class Make>
MovedPoints SelectionCache::moved(Moved wanted, const Make& make) {
    moved_.remove_if([](const Moved& one) {
        return one.selection.expired() || (one.clips.empty() && one.ways.expired());
    });
    const auto* const known = mostRecent(moved_, [&](const Moved& one) {
        return one.selection.lock() == wanted.selection.lock() && one.ways.lock() == wanted.ways.lock() &&
               one.share == wanted.share && one.clips == wanted.clips &&
               one.values.lock() == wanted.values.lock();
    });
    if (known != nullptr) return known->points;
    while (moved_.size() >= keptMoved) moved_.pop_back();
    wanted.points = make();
    auto points = wanted.points;
    if (points.selection->points <= mostMoved) moved_.push_front(std::move(wanted));
    return points;
}

}  // namespace mote::render
