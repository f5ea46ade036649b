// SPDX-License-Identifier: GPL-3.0-or-later
//
// CountedCache keeps what is made of data, beside them and as often as somebody looks at them in another way:
// a table for a key. Each table is a block of a budget (block_budget.h), so that tables, steps and particles
// make room for each other; who still holds one that had to go keeps it, and it counts as long. It holds no
// data alive. One thread asks it; the budget may give up tables from any.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "storage/blocks/block_budget.h"
#include "storage/blocks/counted_memory.h"

namespace mote::storage {

template <class Key, class Made>
class CountedCache final : private BudgetedBlocks {
  public:
    static constexpr std::size_t mostKept = 16;

    CountedCache() = default;
    ~CountedCache() { countTo(nullptr); }
    CountedCache(const CountedCache&) = delete;
    CountedCache& operator=(const CountedCache&) = delete;

    /// Counts to `budget` from now on; to none if it is null, as at first. Forgets what was made.
    void countTo(std::shared_ptr<BlockBudget> budget) {
        if (budget_) budget_->leave(*this);
        for (Slot& slot : slots_) clear(slot);
        budget_ = std::move(budget);
        if (budget_) budget_->enter(*this);
    }

    /// What was made of `data` for `key`, else what `make` gives now, `bytes` of it, whatever there is room
    /// for: a picture needs it. Those that were used last are kept, `most` of them or fewer. Throws what
    /// `make` throws.
    template <class Make>
    std::shared_ptr<const Made> of(const std::shared_ptr<const void>& data, const Key& key, std::size_t most,
                                   std::uint64_t bytes, const Make& make) {
        if (auto known = find(data, key)) return known;
        Slot& slot = emptySlot(std::clamp<std::size_t>(most, 1, mostKept));
        if (budget_) budget_->takeMakingRoom(bytes);
        CountedMemory counted(budget_, bytes);
        Made made = make();
        auto kept = std::make_shared<Kept>(Kept{std::move(counted), std::move(made)});
        const std::lock_guard lock(mutex_);
        slot.data = data;
        slot.address = data.get();
        slot.key = key;
        slot.kept = kept;
        use(slot);
        return {kept, &kept->value};
    }

    /// Gives up what belongs to data that nobody else holds any more.
    void dropExpired() {
        for (Slot& slot : slots_) {
            if (slot.data.expired()) clear(slot);
        }
    }

  private:
    struct Kept {
        CountedMemory counted;
        Made value;
    };
    /// Its thread alone writes all but `kept`, which may go at any time.
    struct Slot {
        std::weak_ptr<const void> data;
        const void* address = nullptr;  ///< of the data; others may stand there when they are gone
        std::optional<Key> key;
        std::uint64_t order = 0;          ///< of its last use
        std::atomic<Generation> used{0};  ///< 0: it is empty
        std::shared_ptr<Kept> kept = {};  ///< under the mutex
    };

    // The slots as the budget sees them.
    std::size_t blockCount() const override { return mostKept; }
    Generation usedIn(std::size_t slot) const override {
        return slots_[slot].used.load(std::memory_order_relaxed);
    }
    std::uint64_t blockSize(std::size_t) const override { return 0; }
    std::uint64_t giveUp(std::size_t slot, Generation used) const override {
        clear(slots_[slot], used);
        return 0;
    }

    std::shared_ptr<const Made> find(const std::shared_ptr<const void>& data, const Key& key) {
        const std::lock_guard lock(mutex_);
        for (Slot& slot : slots_) {
            if (!slot.kept || slot.address != data.get() || slot.data.expired() || slot.key != key) continue;
            use(slot);
            return {slot.kept, &slot.kept->value};
        }
        return nullptr;
    }
    /// Under the mutex.
    void use(Slot& slot) {
        slot.order = ++uses_;
        slot.used = budget_ ? budget_->generation() : 1;
    }
    /// So that no more than `most` are kept with what comes there.
    Slot& emptySlot(std::size_t most) {
        std::array<std::pair<std::uint64_t, Slot*>, mostKept> latest;
        std::transform(slots_.begin(), slots_.end(), latest.begin(),
                       [](Slot& slot) { return std::pair(slot.used == 0 ? 0 : slot.order, &slot); });
        std::sort(latest.begin(), latest.end(), std::greater<>());
        for (std::size_t i = most - 1; i < mostKept; ++i) clear(*latest[i].second);
        return *latest[most - 1].second;
    }
    void clear(Slot& slot) const { clear(slot, slot.used); }
    /// Unless it was used after `used`.
    void clear(Slot& slot, Generation used) const {
        std::shared_ptr<Kept> gone;  // it ends when the mutex is free
        const std::lock_guard lock(mutex_);
        if (!slot.kept || slot.used != used) return;
        gone = std::move(slot.kept);
        gone->counted.giveUp();
        slot.used = 0;
    }

    std::shared_ptr<BlockBudget> budget_;
    mutable std::mutex mutex_;  // never held while the budget is asked for room
    mutable std::array<Slot, mostKept> slots_;
    std::uint64_t uses_ = 0;
};

}  // namespace mote::storage
