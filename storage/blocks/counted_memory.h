// SPDX-License-Identifier: GPL-3.0-or-later
//
// CountedMemory: the bytes of a block that others may hold beyond its owner, counted to a budget until the
// last of them lets it go. Part of what is shared; whoever owns the block says when it has given it up.
// Move-only; any thread, one at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "storage/blocks/block_budget.h"

namespace mote::storage {

class CountedMemory {
  public:
    /// Bytes that `budget` has counted; null: nobody counts.
    CountedMemory(std::shared_ptr<BlockBudget> budget, std::uint64_t bytes)
        : budget_(std::move(budget)), bytes_(bytes) {}
    CountedMemory(CountedMemory&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)), bytes_(other.bytes_), givenUp_(other.givenUp_) {}
    CountedMemory& operator=(CountedMemory&&) = delete;
    ~CountedMemory() {
        if (!budget_) return;
        if (givenUp_) budget_->heldNoMore(bytes_);
        budget_->giveBack(bytes_);
    }

    std::uint64_t bytes() const { return bytes_; }
    /// Counts so many in their place. False if blocks that were used before `generation` leave no room for
    /// more: nothing changes then.
    bool resize(std::uint64_t bytes, BlockBudget::Generation generation) {
        if (budget_ && bytes > bytes_ && !budget_->take(bytes - bytes_, generation)) return false;
        if (budget_ && bytes < bytes_) budget_->giveBack(bytes_ - bytes);
        bytes_ = bytes;
        return true;
    }
    /// The owner keeps it no longer; who still holds it does. Once.
    void giveUp() {
        givenUp_ = true;
        if (budget_) budget_->stillHeld(bytes_);
    }

  private:
    std::shared_ptr<BlockBudget> budget_;
    std::uint64_t bytes_;
    bool givenUp_ = false;
};

}  // namespace mote::storage
