// SPDX-License-Identifier: GPL-3.0-or-later
//
// HeldMemory: bytes of pictures that wait, counted to what data may take (storage/blocks/block_budget.h), so
// that blocks make room for them. Given back when it goes. Move-only; any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "storage/blocks/block_budget.h"

namespace mote::server {

class HeldMemory {
  public:
    HeldMemory() = default;  ///< nothing
    HeldMemory(HeldMemory&& other) noexcept { swap(other); }
    HeldMemory& operator=(HeldMemory&& other) noexcept {
        HeldMemory(std::move(other)).swap(*this);
        return *this;
    }
    ~HeldMemory() {
        if (budget_) budget_->giveBack(bytes_);
    }

    /// Nothing if blocks that are in use leave no room. `budget`: null if nobody counts.
    static std::optional<HeldMemory> whereThereIsRoom(std::shared_ptr<storage::BlockBudget> budget,
                                                      std::uint64_t bytes) {
        if (budget && !budget->take(bytes, budget->generation())) return std::nullopt;
        return HeldMemory(std::move(budget), bytes);
    }
    /// Counts them in any case: they are there.
    static HeldMemory of(std::shared_ptr<storage::BlockBudget> budget, std::uint64_t bytes) {
        if (budget) budget->takeMakingRoom(bytes);
        return HeldMemory(std::move(budget), bytes);
    }

  private:
    HeldMemory(std::shared_ptr<storage::BlockBudget> budget, std::uint64_t bytes)
        : budget_(std::move(budget)), bytes_(bytes) {}
    void swap(HeldMemory& other) noexcept {
        std::swap(budget_, other.budget_);
        std::swap(bytes_, other.bytes_);
    }

    std::shared_ptr<storage::BlockBudget> budget_;
    std::uint64_t bytes_ = 0;
};

}  // namespace mote::server
