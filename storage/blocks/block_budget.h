// SPDX-License-Identifier: GPL-3.0-or-later
//
// BlockBudget: how much memory blocks may take together, those of all mapped arrays and whatever else is
// loaded and may go again, and which of them go when there is not enough: those that were used longest ago,
// of equals those that lie later (the halo is the head of the points). Shared by all that has such blocks;
// any thread.
//
// Use is counted in generations, one a picture. Whatever was used in a generation that is not over is kept,
// so that what a picture holds in its hands does not vanish beneath it: beginGeneration() belongs to the one
// thread that draws.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

namespace mote::storage {

/// Blocks that may leave memory. Asked from any thread.
class BudgetedBlocks {
  public:
    using Generation = std::uint32_t;  ///< from 1

    virtual std::size_t blockCount() const = 0;
    /// The generation in which a block was last used; 0: it is not in memory.
    virtual Generation usedIn(std::size_t block) const = 0;
    virtual std::uint64_t blockSize(std::size_t block) const = 0;  ///< bytes; 0 if it counts itself
    /// Takes a block out of memory, but not if it was used after `used`; bytes that are free now, 0 if
    /// it counts itself (CountedMemory). Must not ask the budget for room.
    virtual std::uint64_t giveUp(std::size_t block, Generation used) const = 0;

  protected:
    BudgetedBlocks() = default;
    BudgetedBlocks(const BudgetedBlocks&) = default;
    BudgetedBlocks(BudgetedBlocks&&) = default;
    BudgetedBlocks& operator=(const BudgetedBlocks&) = default;
    BudgetedBlocks& operator=(BudgetedBlocks&&) = default;
    ~BudgetedBlocks() = default;
};

class BlockBudget {
  public:
    using Generation = BudgetedBlocks::Generation;

    explicit BlockBudget(std::uint64_t bytes) : limit_(bytes) {}

    std::uint64_t limit() const { return limit_; }  ///< bytes
    /// Bytes of the blocks that are in memory, those that were given up and are still held among them.
    std::uint64_t resident() const { return resident_.load(std::memory_order_relaxed); }

    Generation generation() const { return generation_.load(std::memory_order_relaxed); }
    Generation beginGeneration() { return generation_.fetch_add(1, std::memory_order_relaxed) + 1; }

    /// Counts so many bytes as in memory, after giving up blocks that were last used before `generation`
    /// if there is no room for them. False if that is not enough: nothing is counted then, though
    /// blocks that are older may be gone. Other blocks go for those that were given up and are still held;
    /// but if none is left to go they are passed over, as nobody can be asked to let them go. Counting is
    /// part of finding the room, so that two threads do not find the same.
    bool take(std::uint64_t bytes, Generation generation);
    /// Counts them whatever there is room for.
    void takeAnyway(std::uint64_t bytes) { resident_.fetch_add(bytes, std::memory_order_relaxed); }
    /// The same, after giving up blocks that the present picture does not use if there is no room: for what
    /// cannot be done without.
    void takeMakingRoom(std::uint64_t bytes) {
        if (!take(bytes, generation())) takeAnyway(bytes);
    }
    /// Gives back bytes that were taken and did not come in.
    void giveBack(std::uint64_t bytes) { resident_.fetch_sub(bytes, std::memory_order_relaxed); }

    /// Of the bytes in memory, so many were given up and somebody still holds them; or no more does.
    void stillHeld(std::uint64_t bytes) { stillHeld_.fetch_add(bytes, std::memory_order_relaxed); }
    void heldNoMore(std::uint64_t bytes) { stillHeld_.fetch_sub(bytes, std::memory_order_relaxed); }

    /// Blocks that count from now on, none that counted before; both while they are not used.
    void enter(const BudgetedBlocks& blocks);
    void leave(const BudgetedBlocks& blocks);

  private:
    struct Candidate {
        Generation used;
        std::size_t block;
        const BudgetedBlocks* owner;
    };
    bool takeFree(std::uint64_t bytes, std::uint64_t limit);
    std::vector<Candidate> oldest(Generation before, std::size_t most) const;

    const std::uint64_t limit_;
    std::atomic<std::uint64_t> resident_{0}, stillHeld_{0};
    std::atomic<Generation> generation_{1};
    std::mutex mutex_;
    std::vector<const BudgetedBlocks*> owners_;  // under the mutex
};

}  // namespace mote::storage
