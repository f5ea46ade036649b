// SPDX-License-Identifier: GPL-3.0-or-later
//
// MessageAccount: what messages of one client take in memory until they are answered. It is bounded for each
// client, and counted to what data may take, as replies are: so many clients with much to ask take the place
// of blocks, and no memory beyond. What a message takes has little to do with its bytes on the wire: a list
// of small parts takes ten times as much. Owned by its session; one thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>

#include "server/data/held_memory.h"

namespace mote::server {

class MessageAccount {
  public:
    /// A message that is there; given back at its end. Move-only; may outlive the account.
    class Hold {
      public:
        Hold() = default;  ///< nothing
        Hold(Hold&& other) noexcept { swap(other); }
        Hold& operator=(Hold&& other) noexcept {
            Hold(std::move(other)).swap(*this);
            return *this;
        }
        ~Hold() {
            if (held_) *held_ -= bytes_;
        }

      private:
        friend class MessageAccount;
        Hold(std::shared_ptr<std::size_t> held, std::size_t bytes, HeldMemory memory)
            : held_(std::move(held)), bytes_(bytes), memory_(std::move(memory)) {
            *held_ += bytes_;
        }
        void swap(Hold& other) noexcept {
            std::swap(held_, other.held_);
            std::swap(bytes_, other.bytes_);
            std::swap(memory_, other.memory_);
        }

        std::shared_ptr<std::size_t> held_;
        std::size_t bytes_ = 0;
        HeldMemory memory_;
    };

    /// `most`: bytes. `budget`: null where nobody counts.
    MessageAccount(std::size_t most, std::shared_ptr<storage::BlockBudget> budget)
        : most_(most), budget_(std::move(budget)) {}

    std::size_t held() const { return *held_; }  ///< bytes
    /// Whether there is room for another message, of whatever size: who waits for that holds one too many at
    /// most.
    bool room() const { return *held_ < most_; }
    /// Whether there is room for one of so many bytes.
    bool roomFor(std::size_t bytes) const { return bytes <= most_ - std::min(most_, *held_); }
    /// Counts it in any case: it is there.
    Hold hold(std::size_t bytes) {
        constexpr std::size_t large = 64 << 10;  // smaller ones are part of what the program may take
        return {held_, bytes, bytes < large ? HeldMemory() : HeldMemory::of(budget_, bytes)};
    }

  private:
    const std::size_t most_;
    const std::shared_ptr<storage::BlockBudget> budget_;
    const std::shared_ptr<std::size_t> held_ = std::make_shared<std::size_t>(0);
};

}  // namespace mote::server
