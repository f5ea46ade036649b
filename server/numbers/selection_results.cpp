// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/selection_results.h"

#include <algorithm>

#include "protocol/base/most_recent.h"
#include "storage/numbers/id_set.h"
#include "storage/numbers/select_points.h"
#include "storage/storage_error.h"

namespace mote::server {
namespace {

constexpr std::uint64_t bytesACorner = 700;  // of a polygon's grid, at most
constexpr std::uint64_t valueBytes = 8;
constexpr std::uint64_t chosenBytes = 24;  // of a step of chosen points, a point

/// What finding a selection's points takes, at most, in a run whose greatest step has so many points.
std::uint64_t bytesOf(const Selection& selection, std::uint64_t points) {
    std::uint64_t bytes = selection.ids.size() * 2 * valueBytes;
    if (!selection.ids.empty()) bytes += points / valueBytes;
    // The ids of another step's points, and that step's mask; or a bit an id.
    if (selection.step) bytes += points * valueBytes + 2 * points / valueBytes;
    if (selection.polygon) bytes += selection.polygon->points.size() * bytesACorner;
    if (selection.lasso) bytes += selection.lasso->points.size() * bytesACorner;
    if (selection.outermost) bytes += std::uint64_t{40} << 20;
    for (const auto* const list : {&selection.all, &selection.any, &selection.negated}) {
        for (const auto& inner : *list) bytes += bytesOf(inner, points);
    }
    return bytes;
}

std::uint64_t mostPoints(const storage::RunSteps& run) {
    std::uint64_t most = 0;
    for (const auto& step : run.manifest().steps()) most = std::max(most, step.particles());
    return most;
}

/// Whether it names ids and says nothing else but where it was made.
bool idsAlone(const Selection& selection) {
    if (selection.ids.empty()) return false;
    Selection same;
    same.ids = selection.ids;
    same.step = selection.step;
    return selection == same;
}

}  // namespace

template <class Member>
Member SelectionResults::find(Member Entry::*member, const Run& run, std::uint32_t step,
                              const Selection& selection) {
    const std::lock_guard lock(mutex_);
    const auto* const found = mostRecent(entries_, [&](const Entry& entry) {
        return entry.*member != nullptr && entry.step == step && entry.run.lock() == run &&
               entry.selection == selection;
    });
    return found == nullptr ? nullptr : found->*member;
}

/// What there is no memory for is not kept.
void SelectionResults::keep(Entry entry, std::uint64_t bytes) {
    std::list<Entry> old;  // ends without the mutex
    const std::lock_guard lock(mutex_);
    const auto most = memory_->limit() / keptShare;
    if (bytes > most) return;
    while (!entries_.empty() && (entries_.size() >= kept || bytes_ + bytes > most)) {
        bytes_ -= entries_.back().memory.bytes();
        old.splice(old.begin(), entries_, std::prev(entries_.end()));
    }
    bytes_ += entry.memory.bytes();
    entries_.push_front(std::move(entry));
}

Result<SelectionResults::Mask> SelectionResults::points(const Run& run, std::uint32_t step,
                                                        const Selection& selection,
                                                        const Cancelled& cancelled) {
    if (selection.everything()) return Mask();
    if (auto known = find(&Entry::points, run, step, selection)) return known;
    const auto points = mostPoints(*run);
    const auto own = points / valueBytes + selection.ids.size() * valueBytes;
    MOTE_ASSIGN_OR_RETURN(auto hold, memory_->take(own + bytesOf(selection, points), cancelled));
    MOTE_ASSIGN_OR_RETURN(auto found, storage::selectPoints(selection, *run, step, cancelled));
    auto mask = std::make_shared<const storage::PointMask>(std::move(found));
    hold.shrink(own);
    keep({run, step, selection, mask, nullptr, std::move(hold)}, own);
    return mask;
}

Result<SelectionResults::Chosen> SelectionResults::chosen(const Run& run, std::uint32_t step,
                                                          const Selection& selection,
                                                          const Cancelled& cancelled) {
    MOTE_ASSIGN_OR_RETURN(const auto mask, points(run, step, selection, cancelled));
    if (!mask) return Chosen();
    if (auto known = find(&Entry::chosen, run, step, selection)) return known;
    MOTE_ASSIGN_OR_RETURN(const auto numbers, run->step(step));
    MOTE_ASSIGN_OR_RETURN(const auto hold, memory_->take(chosenBytes * mask->count(), cancelled));
    MOTE_ASSIGN_OR_RETURN(
        const Chosen made,
        storage::SelectedStep::make(*numbers.points, *mask, run->manifest().leaf_capacity(), cancelled));
    auto own = memory_->tryTake(made->bytes());
    if (own.bytes() > 0) keep({run, step, selection, nullptr, nullptr, std::move(own), made}, made->bytes());
    return made;
}

Result<SelectionResults::Ids> SelectionResults::ids(const Run& run, std::uint32_t step,
                                                    const Selection& selection, const Cancelled& cancelled) {
    if (idsAlone(selection) && !selection.step)
        return std::make_shared<const std::vector<std::uint64_t>>(selection.ids);
    const auto made = selection.step.value_or(step);
    if (auto known = find(&Entry::ids, run, made, selection)) return known;
    MOTE_ASSIGN_OR_RETURN(const auto numbers, run->step(made));
    if (!numbers.columns) return storage::withoutColumns("byId");
    if (!numbers.columns->hasIds()) return storage::withoutIds("byId");
    MOTE_ASSIGN_OR_RETURN(auto mask, points(run, made, selection, cancelled));
    if (!mask) {
        Selection all;
        all.density = Selection::Density{};
        MOTE_ASSIGN_OR_RETURN(mask, points(run, made, all, cancelled));
    }
    MOTE_ASSIGN_OR_RETURN(auto hold, memory_->take(2 * valueBytes * mask->count(), cancelled));
    try {
        const auto set = storage::IdSet::of(*mask, *numbers.columns, cancelled);
        if (!set) return Error{ErrorCode::cancelled, "", "cancelled"};
        auto ids = std::make_shared<const std::vector<std::uint64_t>>(set->list());
        const auto own = valueBytes * ids->size();
        hold.shrink(own);
        keep({run, made, selection, nullptr, ids, std::move(hold)}, own);
        return ids;
    } catch (const storage::StorageError& error) {
        return error.error();
    }
}

}  // namespace mote::server
