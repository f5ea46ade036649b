// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/hybrid_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <utility>

#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/give_way.h"

namespace mote::server {
namespace {

Status checkKind(const storage::Catalogue::Entry& entry) {
    if (entry.manifest->kind() == "hybrid") return success();
    return Error{
        ErrorCode::invalidArgument, "dataset",
        fmt::format("\"{}\" is of kind \"{}\", not a hybrid volume", entry.name, entry.manifest->kind())};
}

Error noRoom(std::uint64_t bytes) {
    return {ErrorCode::resourceExhausted, "dataset",
            fmt::format("its step takes {} MiB, more than the server has for data", bytes >> 20)};
}

}  // namespace

HybridCache::HybridCache(std::shared_ptr<storage::BlockBudget> budget, unsigned threads,
                         std::function<void()> arrived)
    : budget_(std::move(budget)), arrived_(std::move(arrived)) {
    budget_->enter(*this);
    for (unsigned i = 0; i < std::max(1U, threads); ++i) {
        threads_.emplace_back([this] {
            storage::giveWay();
            run();
        });
    }
}

HybridCache::~HybridCache() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
    for (auto& thread : threads_) thread.join();
    budget_->leave(*this);
}

Result<HybridCache::Step> HybridCache::step(const storage::Catalogue::Entry& entry, std::uint32_t index,
                                            HybridRepresentation representation) {
    MOTE_RETURN_IF_ERROR(checkKind(entry));
    const auto parts = render::hybridParts(entry.manifest->hybrid(), representation);
    if (!parts.ok()) return parts.error();
    const Place place{entry.manifest, entry.directory, index, *parts};
    {
        const std::lock_guard lock(mutex_);
        Slot* const slot = find(place);
        if (slot != nullptr && slot->state == State::failed) {
            Error error = *std::move(slot->error);
            clear(*slot);  // the next view tries anew
            return error;
        }
        const bool there = slot != nullptr && slot->state == State::loaded;
        const bool late = slot != nullptr && slot->state == State::late;
        if (there) {
            slot->used = budget_->turn();
            slot->wanted = false;
        } else if (!late && place.parts != HybridRepresentation::volume) {
            want(place);
        }
        expectNext(place, there);
        if (there) return slot->step;
        if (!late && place.parts != HybridRepresentation::volume) return Step();
    }
    return loadAtOnce(place);
}

bool HybridCache::played(const storage::Catalogue::Entry& entry) {
    const std::lock_guard lock(mutex_);
    const auto& series = series_.of(entry.manifest, entry.manifest->hybrid().steps_size());
    return !series.order.next(1).empty();
}

Result<HybridCache::Step> HybridCache::volume(const storage::Catalogue::Entry& entry, std::uint32_t index) {
    MOTE_RETURN_IF_ERROR(checkKind(entry));
    const Place place{entry.manifest, entry.directory, index, HybridRepresentation::volume};
    {
        const std::lock_guard lock(mutex_);
        Slot* const slot = find(place);
        if (slot != nullptr && slot->state == State::loaded) {
            slot->used = budget_->turn();
            return slot->step;
        }
    }
    return loadAtOnce(place);
}

std::size_t HybridCache::loadedSteps() const {
    const std::lock_guard lock(mutex_);
    return count(State::loaded);
}

std::size_t HybridCache::stepsUnderWay() const {
    const std::lock_guard lock(mutex_);
    return count(State::waiting) + count(State::loading);
}

std::uint64_t HybridCache::giveUp(std::size_t index, Turn used) const {
    Step gone;  // it ends when the mutex is free
    const std::lock_guard lock(mutex_);
    Slot& slot = slots_[index];
    if (slot.state != State::loaded || slot.used != used) return 0;
    gone = std::move(slot.step);
    const auto bytes = slot.bytes;
    slot.used = 0;
    slot.state = slot.wanted ? State::late : State::empty;
    return bytes;
}

std::size_t HybridCache::count(State state) const {
    return static_cast<std::size_t>(
        std::count_if(slots_.begin(), slots_.end(), [&](const Slot& slot) { return slot.state == state; }));
}

HybridCache::Slot* HybridCache::find(const Place& place) const {
    const auto found = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& slot) {
        return slot.state != State::empty && slot.place == place;
    });
    return found == slots_.end() ? nullptr : &*found;
}

void HybridCache::clear(Slot& slot) const {
    if (slot.used.exchange(0) != 0) budget_->giveBack(slot.bytes);
    slot.step.reset();
    slot.error.reset();
    slot.wanted = false;
    slot.state = State::empty;
}

/// Its own, else that which is missed least; there are fewer threads than slots.
HybridCache::Slot& HybridCache::slotFor(const Place& place) {
    if (Slot* const own = find(place)) return *own;
    const auto worth = [](const Slot& slot) {
        if (slot.state == State::empty) return std::pair(0, Turn{0});
        const bool fixed = slot.state == State::loading;
        return std::pair(fixed ? 3 : slot.wanted ? 2 : 1, slot.used.load());
    };
    Slot& slot = *std::min_element(slots_.begin(), slots_.end(),
                                   [&](const Slot& a, const Slot& b) { return worth(a) < worth(b); });
    std::erase(line_, &slot);
    clear(slot);
    slot.place = place;
    return slot;
}

/// Takes a step whose bytes were counted; returns the one that is kept.
HybridCache::Step HybridCache::keep(const Place& place, Step step) {
    Slot& slot = slotFor(place);
    std::erase(line_, &slot);
    if (slot.state == State::loaded) {
        budget_->giveBack(step->bytes());
        return slot.step;
    }
    slot.state = State::loaded;
    slot.bytes = step->bytes();
    slot.step = std::move(step);
    slot.used = budget_->turn();
    return slot.step;
}

/// First of all that waits. Nobody waits for the dataset's other steps any more.
void HybridCache::want(const Place& place) {
    for (Slot& slot : slots_) {
        if (slot.place.manifest == place.manifest) slot.wanted = false;
    }
    Slot& slot = slotFor(place);
    slot.wanted = true;
    if (slot.state == State::loading) return;
    std::erase(line_, &slot);
    slot.state = State::waiting;
    line_.push_front(&slot);
    wake_.notify_one();
}

/// Takes what waits, and nobody waits for, out of the line.
void HybridCache::leaveOut(const std::shared_ptr<const proto::Manifest>& manifest) {
    const auto outdated = [&](Slot* slot) {
        if (slot->place.manifest != manifest || slot->wanted) return false;
        clear(*slot);
        return true;
    };
    line_.erase(std::remove_if(line_.begin(), line_.end(), outdated), line_.end());
}

/// `there`: the step itself is. Otherwise what is there of the next ones may go for it.
void HybridCache::expectNext(const Place& place, bool there) {
    auto& series = series_.of(place.manifest, place.manifest->hybrid().steps_size());
    const bool moved = series.order.asked(place.index);
    const bool same = std::exchange(series.need, place.parts) == place.parts;
    if (moved || !same) leaveOut(place.manifest);
    for (const auto index : series.order.next(stepsAhead)) {
        const Place next{place.manifest, place.directory, index, place.parts};
        Slot* const known = find(next);
        if (known != nullptr && known->state == State::loaded && there) known->used = budget_->turn();
        if (known != nullptr || (!moved && same)) continue;
        Slot& slot = slotFor(next);
        slot.state = State::waiting;
        line_.push_back(&slot);
        wake_.notify_one();
    }
}

/// Counts what it takes. Errors: also resourceExhausted where there is no room but for what was used in
/// `turn` or later.
Result<HybridCache::Step> HybridCache::load(const Place& place, Turn turn) const {
    const auto& hybrid = place.manifest->hybrid();
    const auto expected = render::hybridBytes(hybrid, place.index, place.parts) +
                          render::hybridLoadingBytes(hybrid, place.index, place.parts);
    if (!budget_->take(expected, turn)) return noRoom(expected);
    const auto loaded = [&]() -> Result<Step> {
        try {
            return render::loadHybrid(place.directory, *place.manifest, place.index, place.parts,
                                      [this] { return stopping_.load(); });
        } catch (const std::bad_alloc&) {
            return noRoom(expected);
        } catch (const std::exception& failure) {
            return Error{ErrorCode::internal, place.directory.string(), failure.what()};
        }
    }();
    const auto bytes = loaded.ok() ? (*loaded)->bytes() : 0;
    if (bytes <= expected) {
        budget_->giveBack(expected - bytes);
        return loaded;
    }
    if (budget_->take(bytes - expected, turn)) return loaded;
    budget_->giveBack(expected);
    return noRoom(bytes);
}

Result<HybridCache::Step> HybridCache::loadAtOnce(const Place& place) {
    auto loaded = load(place, budget_->turn());
    const std::lock_guard lock(mutex_);
    if (loaded.ok()) {
        auto kept = keep(place, *std::move(loaded));
        find(place)->wanted = false;
        return kept;
    }
    Slot* const slot = find(place);
    if (slot != nullptr && slot->state == State::late) clear(*slot);
    return loaded.error();
}

void HybridCache::run() {
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [this] { return stopping_ || !line_.empty(); });
        if (stopping_) return;
        Slot& slot = *line_.front();
        line_.pop_front();
        slot.state = State::loading;
        const Place place = slot.place;
        lock.unlock();
        finish(place, load(place, budget_->turn()));
        arrived_();
        lock.lock();
    }
}

/// What is wrong with a step that nobody asked for will be said when it is asked for.
void HybridCache::finish(const Place& place, Result<Step> loaded) {
    const std::lock_guard lock(mutex_);
    if (loaded.ok()) {
        keep(place, *std::move(loaded));
        return;
    }
    Slot* const slot = find(place);
    if (slot == nullptr || slot->state != State::loading) return;  // it was loaded at once meanwhile
    if (!slot->wanted) return clear(*slot);
    const bool room = loaded.error().code != ErrorCode::resourceExhausted;
    slot->state = room ? State::failed : State::late;
    slot->error = loaded.error();
}

}  // namespace mote::server
