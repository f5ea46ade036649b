// SPDX-License-Identifier: GPL-3.0-or-later
//
// BlockBudget: how much memory the blocks of all mapped arrays may take together, and which of them go when
// there is not enough: those that were used longest ago, of equals those that lie later in their array (the
// halo is the head of the points). Shared by the steps that are opened with it; any thread.
//
// Use is counted in turns, one a picture. Whatever was used in a turn that is not over is kept, so that what
// a picture holds in its hands does not vanish beneath it: beginTurn() belongs to the one thread that draws.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

namespace mote::storage {

class VerifiedArray;

class BlockBudget {
  public:
    using Turn = std::uint32_t;  ///< from 1

    explicit BlockBudget(std::uint64_t bytes) : limit_(bytes) {}

    std::uint64_t limit() const { return limit_; }  ///< bytes
    /// Bytes of the blocks that are in memory.
    std::uint64_t resident() const { return resident_.load(std::memory_order_relaxed); }

    Turn turn() const { return turn_.load(std::memory_order_relaxed); }
    Turn beginTurn() { return turn_.fetch_add(1, std::memory_order_relaxed) + 1; }

    /// Room for so many bytes, by giving up blocks that were last used before `turn`. False where that is not
    /// enough: nothing is given up for nothing then, but blocks that are older still.
    bool makeRoom(std::uint64_t bytes, Turn turn);

    /// Of the arrays: one that counts from now on, none that counted before; both while it is not used.
    void enter(const VerifiedArray& array);
    void leave(const VerifiedArray& array);
    /// Of the arrays: a block came in.
    void add(std::uint64_t bytes) { resident_.fetch_add(bytes, std::memory_order_relaxed); }

  private:
    struct Candidate {
        Turn used;
        std::size_t block;
        const VerifiedArray* array;
    };
    std::vector<Candidate> oldest(Turn before, std::size_t most) const;

    const std::uint64_t limit_;
    std::atomic<std::uint64_t> resident_{0};
    std::atomic<Turn> turn_{1};
    std::mutex mutex_;
    std::vector<const VerifiedArray*> arrays_;  // under the mutex
};

}  // namespace mote::storage
