// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/residency.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "storage/caught_error.h"

namespace mote::server {
namespace {

Error noRoom(std::uint64_t bytes) {
    return {ErrorCode::resourceExhausted, "dataset",
            fmt::format("takes {} MiB in memory, more than the server has for data", bytes >> 20)};
}

}  // namespace

Residency::Residency(std::shared_ptr<storage::BlockBudget> budget, unsigned threads,
                     std::function<void()> arrived)
    : budget_(std::move(budget)),
      arrived_(std::move(arrived)),
      threads_(threads, [this] { return loadOne(); }) {
    budget_->enter(*this);
}

Residency::~Residency() {
    stopping_ = true;
    threads_.stop();
    budget_->leave(*this);
    for (Slot& slot : slots_) clear(slot);
}

Result<Resident> Residency::get(const AnyLoadable& what) {
    std::unique_lock lock(mutex_);
    Slot* slot = &slotFor(what);
    const bool there = slot->state == State::ready;
    const bool late = slot->state == State::late;
    if (there) slot->used = budget_->generation();  // what is expected takes the slots of others
    if (late || slot->state == State::empty || slot->underWay()) want(*slot);
    if (what.steps > 1) expectNext(what, there);
    if (late) {
        settled_.wait(lock, [&] { return (slot = find(what)) == nullptr || !slot->underWay(); });
    }
    return slot == nullptr ? Resident() : take(*slot);
}

/// What came of it, as far as anything did.
Result<Resident> Residency::take(Slot& slot) {
    if (slot.state == State::ready) {
        slot.wanted = false;
        return Resident{{slot.kept, slot.kept->value.get()}, slot.kept->counted.bytes()};
    }
    if (!slot.error) return Resident();
    Error error = *std::move(slot.error);
    clear(slot);  // the next view tries anew
    return error;
}

bool Residency::played(const storage::Catalogue::Entry& dataset) const {
    const std::lock_guard lock(mutex_);
    const auto* const series = series_.find(dataset.manifest);
    return series != nullptr && !series->order.next(1).empty();
}

std::size_t Residency::loaded() const {
    const std::lock_guard lock(mutex_);
    const auto ready = [](const Slot& slot) { return slot.state == State::ready; };
    return static_cast<std::size_t>(std::count_if(slots_.begin(), slots_.end(), ready));
}

std::vector<std::uint32_t> Residency::loadedSteps(const storage::Catalogue::Entry& dataset) const {
    std::map<std::uint32_t, int> parts;
    int most = 0;
    {
        const std::lock_guard lock(mutex_);
        for (const Slot& slot : slots_) {
            const bool ours = slot.state == State::ready && slot.what->dataset.manifest == dataset.manifest;
            if (ours) most = std::max(most, ++parts[slot.what->step]);
        }
    }
    std::vector<std::uint32_t> steps;
    for (const auto& [step, count] : parts) {
        if (count == most) steps.push_back(step);
    }
    return steps;
}

std::size_t Residency::underWay() const {
    const std::lock_guard lock(mutex_);
    const auto coming = [](const Slot& slot) { return slot.underWay(); };
    return static_cast<std::size_t>(std::count_if(slots_.begin(), slots_.end(), coming));
}

std::uint64_t Residency::giveUp(std::size_t index, Generation used) const {
    std::shared_ptr<Kept> gone;  // it ends when the mutex is free
    const std::lock_guard lock(mutex_);
    Slot& slot = slots_[index];
    if (slot.state != State::ready || slot.used != used) return 0;
    gone = std::move(slot.kept);
    gone->counted.giveUp();
    slot.used = 0;
    slot.state = slot.wanted ? State::late : State::empty;
    return 0;
}

Residency::Slot* Residency::find(const AnyLoadable& what) {
    const auto found = std::find_if(slots_.begin(), slots_.end(),
                                    [&](const Slot& slot) { return slot.what && slot.what->sameAs(what); });
    return found == slots_.end() ? nullptr : &*found;
}

void Residency::clear(Slot& slot) {
    if (slot.kept) slot.kept->counted.giveUp();
    slot.kept.reset();
    slot.used = 0;
    slot.error.reset();
    slot.wanted = false;
    slot.state = State::empty;
}

/// Its own, else that which is missed least; there are fewer threads than slots.
Residency::Slot& Residency::slotFor(const AnyLoadable& what) {
    if (Slot* const own = find(what)) return *own;
    const auto worth = [](const Slot& slot) {
        if (slot.state == State::empty) return std::pair(0, Generation{0});
        return std::pair(slot.state == State::loading ? 3 : slot.wanted ? 2 : 1, slot.used.load());
    };
    Slot& slot = *std::min_element(slots_.begin(), slots_.end(),
                                   [&](const Slot& a, const Slot& b) { return worth(a) < worth(b); });
    std::erase(line_, &slot);
    clear(slot);
    slot.what = what;
    return slot;
}

/// First of all that waits. Nobody waits for the dataset's other steps any more.
void Residency::want(Slot& slot) {
    for (Slot& other : slots_) {
        const bool sameDataset = other.what && other.what->dataset.manifest == slot.what->dataset.manifest;
        if (sameDataset && other.what->step != slot.what->step) other.wanted = false;
    }
    slot.wanted = true;
    if (slot.state == State::loading) return;
    std::erase(line_, &slot);
    slot.state = State::waiting;
    slot.error.reset();
    line_.push_front(&slot);
    threads_.wake();
}

/// Takes what waits, and nobody waits for, out of the line.
void Residency::leaveOut(const storage::Catalogue::Entry& dataset) {
    std::erase_if(line_, [&](Slot* slot) {
        if (slot->what->dataset.manifest != dataset.manifest || slot->wanted) return false;
        clear(*slot);
        return true;
    });
}

/// `there`: the step itself is. Otherwise what is there of the next ones may go for it.
void Residency::expectNext(const AnyLoadable& what, bool there) {
    auto& series = series_.of(what.dataset.manifest, what.steps);
    const bool moved = series.order.asked(what.step);
    const bool same = std::exchange(series.need, what.part) == what.part;
    if (moved || !same) leaveOut(what.dataset);
    AnyLoadable next = what;
    for (const auto step : series.order.next(stepsAhead)) {
        next.step = step;
        Slot* const known = find(next);
        if (known != nullptr && known->state == State::ready && there) known->used = budget_->generation();
        if ((known != nullptr && known->state != State::empty) || (!moved && same)) continue;
        Slot& slot = slotFor(next);
        slot.state = State::waiting;
        line_.push_back(&slot);
        threads_.wake();
    }
}

/// The thread: what is first in line.
bool Residency::loadOne() {
    std::unique_lock lock(mutex_);
    if (stopping_ || line_.empty()) return false;
    Slot& slot = *line_.front();  // nobody else takes it while it is loading
    line_.pop_front();
    slot.state = State::loading;
    const AnyLoadable what = *slot.what;
    lock.unlock();
    auto loaded = load(what);
    lock.lock();
    finish(slot, std::move(loaded));
    lock.unlock();
    settled_.notify_all();
    arrived_();
    return true;
}

/// Counts what it takes. Errors: also resourceExhausted if there is no room but for what the present
/// picture uses.
Result<std::shared_ptr<Residency::Kept>> Residency::load(const AnyLoadable& what) const {
    const auto generation = budget_->generation();
    const auto expected = what.expected(what.step);
    if (!budget_->take(expected, generation)) return noRoom(expected);
    storage::CountedMemory counted(budget_, expected);
    MOTE_ASSIGN_OR_RETURN(auto loaded, read(what));
    if (!counted.resize(loaded.bytes, generation)) return noRoom(loaded.bytes);
    return std::make_shared<Kept>(Kept{std::move(counted), std::move(loaded.value)});
}

Result<Resident> Residency::read(const AnyLoadable& what) const {
    try {
        return what.load(what.step, [this] { return stopping_.load(); });
    } catch (const std::exception&) {
        return storage::caughtError(noRoom(what.expected(what.step)));
    }
}

/// What is wrong with something that nobody asked for will be said when it is asked for.
void Residency::finish(Slot& slot, Result<std::shared_ptr<Kept>> loaded) {
    if (loaded.ok()) {
        slot.state = State::ready;
        slot.kept = *std::move(loaded);
        slot.used = budget_->generation();
        return;
    }
    if (!slot.wanted) return clear(slot);
    const bool room = loaded.error().code != ErrorCode::resourceExhausted;
    slot.state = room ? State::failed : State::late;
    slot.error = loaded.error();
}

}  // namespace mote::server
