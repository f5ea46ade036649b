// SPDX-License-Identifier: GPL-3.0-or-later
//
// Residency keeps in memory what was drawn last of all that is loaded whole (Loadable), and the next steps of
// a series while it is played. It reads on threads of its own that give way to those that draw, never on the
// thread that asks. Each thing is a block of the budget, so that they and particles make room for each other;
// who still holds one that had to go keeps it, and it counts as long. Owned by DatasetService; any thread may
// ask.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "server/data/loadable.h"
#include "server/data/loading_threads.h"
#include "server/data/played_series.h"
#include "storage/blocks/block_budget.h"
#include "storage/blocks/counted_memory.h"

namespace mote::server {

class Residency final : private storage::BudgetedBlocks {
  public:
    static constexpr std::size_t most = 64;  ///< kept and under way

    /// `arrived` is called on the threads, and must be quick, when something is there or never will be. At
    /// least one thread.
    Residency(std::shared_ptr<storage::BlockBudget> budget, unsigned threads, std::function<void()> arrived);
    /// Gives up what is under way.
    ~Residency();
    Residency(const Residency&) = delete;
    Residency& operator=(const Residency&) = delete;

    /// What is asked for; without a value if it is not in memory: it is brought in, before all that is
    /// only expected, and of a dataset only the latest step. The next steps of a series that is played
    /// follow. What there was no room for, or had to go before it was asked for again, is waited for: or two
    /// of them could take turns for ever. Errors: what became of loading it, said once, then it is tried
    /// anew; resourceExhausted.
    Result<Resident> get(const AnyLoadable& what);
    /// Whether the dataset's steps are asked for in an order.
    bool played(const storage::Catalogue::Entry& dataset) const;

    std::size_t loaded() const;
    /// Indices of the dataset's steps of which as much is in memory as of any, ascending.
    std::vector<std::uint32_t> loadedSteps(const storage::Catalogue::Entry& dataset) const;
    std::size_t underWay() const;  ///< in line, or being loaded

  private:
    enum class State {
        empty,
        waiting,  ///< in line
        loading,
        ready,
        late,   ///< was asked for, but there was no room, or it had to go before it was asked for again
        failed  ///< was asked for
    };
    /// What is there; others hold it by its value.
    struct Kept {
        storage::CountedMemory counted;
        std::shared_ptr<const void> value;
    };
    struct Slot {
        std::optional<AnyLoadable> what;  ///< nothing: empty
        State state = State::empty;
        bool wanted = false;  ///< a picture asked for it and has not had it
        std::shared_ptr<Kept> kept;
        std::optional<Error> error;
        std::atomic<Generation> used{0};

        bool underWay() const { return state == State::waiting || state == State::loading; }
    };

    // The slots as the budget sees them.
    std::size_t blockCount() const override { return most; }
    Generation usedIn(std::size_t slot) const override {
        return slots_[slot].used.load(std::memory_order_relaxed);
    }
    std::uint64_t blockSize(std::size_t) const override { return 0; }
    std::uint64_t giveUp(std::size_t slot, Generation used) const override;

    Result<std::shared_ptr<Kept>> load(const AnyLoadable& what) const;
    Result<Resident> read(const AnyLoadable& what) const;
    bool loadOne();
    // Under the mutex.
    void finish(Slot& slot, Result<std::shared_ptr<Kept>> loaded);
    Slot* find(const AnyLoadable& what);
    Slot& slotFor(const AnyLoadable& what);
    void clear(Slot& slot);
    void want(Slot& slot);
    Result<Resident> take(Slot& slot);
    void leaveOut(const storage::Catalogue::Entry& dataset);
    void expectNext(const AnyLoadable& what, bool there);

    const std::shared_ptr<storage::BlockBudget> budget_;
    const std::function<void()> arrived_;
    std::atomic<bool> stopping_{false};

    mutable std::mutex mutex_;  // never held while the budget is asked for room
    std::condition_variable settled_;
    // Under the mutex.
    mutable std::array<Slot, most> slots_;
    std::deque<Slot*> line_;    // that wait: what is wanted, the latest first; then what is expected
    PlayedSeries<int> series_;  // the part that was asked for last

    LoadingThreads threads_;
};

}  // namespace mote::server
