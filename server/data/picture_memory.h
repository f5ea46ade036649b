// SPDX-License-Identifier: GPL-3.0-or-later
//
// PictureMemory: what pictures under way take, those of all clients together: what plans and drawings need
// while they are made, pixels, and what is encoded and waits to be sent. A part of the server's memory is for
// them alone; beyond it they take of what is for data, of which blocks go. Who asks says all that a picture
// will take at most before any of it is taken. Shared; any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "server/data/held_memory.h"
#include "storage/blocks/block_budget.h"

namespace mote::server {

class PictureMemory : public std::enable_shared_from_this<PictureMemory> {
  public:
    /// What a picture has taken; given back when it goes. Move-only; nothing if it is made so.
    class Taken {
      public:
        Taken() = default;
        Taken(Taken&& other) noexcept { swap(other); }
        Taken& operator=(Taken&& other) noexcept {
            Taken(std::move(other)).swap(*this);
            return *this;
        }
        ~Taken() { shrink(0); }

        std::uint64_t bytes() const { return own_ + more_; }
        /// Gives back all but so many.
        void shrink(std::uint64_t bytes);
        /// Gives back all, and nobody is told: it comes again when its data have, which tells all.
        void leave();
        /// Becomes so many, whatever there is room for: they are there. Of nothing: stays that.
        void become(std::uint64_t bytes);

      private:
        friend class PictureMemory;
        void swap(Taken& other) noexcept {
            std::swap(memory_, other.memory_);
            std::swap(own_, other.own_);
            std::swap(more_, other.more_);
            std::swap(held_, other.held_);
        }

        std::shared_ptr<PictureMemory> memory_;
        std::uint64_t own_ = 0, more_ = 0;  // of their own part, and of what is for data
        HeldMemory held_;                   // `more_`
    };

    /// `own`: bytes that are for pictures alone. `data`: what data are counted to; null: there is no more.
    PictureMemory(std::uint64_t own, std::shared_ptr<storage::BlockBudget> data)
        : own_(own), data_(std::move(data)) {}

    const std::shared_ptr<storage::BlockBudget>& data() const { return data_; }
    /// A picture of so many bytes cannot take more than this at once: small ones may take a little more.
    std::uint64_t most(std::uint64_t bytes) const;
    /// Bytes that nobody has. After take() found too few: but for what data in use have.
    std::uint64_t room() const;
    /// That pictures have, also of what is for data.
    std::uint64_t taken() const;
    /// Nothing while others, or data that are in use, leave no room. Something is left to small pictures,
    /// which need not wait for large ones.
    std::optional<Taken> take(std::uint64_t bytes);
    /// How often something was given back.
    std::uint64_t givenBack() const;
    /// Called after something was given back, by whoever gave it, who may have locked what is its own. None
    /// is called any more when this has returned.
    void whenGivenBack(std::function<void()> tell);

  private:
    std::uint64_t ownFor(std::uint64_t bytes) const;
    void giveBack(std::uint64_t own, std::uint64_t all, bool tells = true);

    const std::uint64_t own_;
    const std::shared_ptr<storage::BlockBudget> data_;
    mutable std::mutex mutex_;
    std::uint64_t used_ = 0, taken_ = 0;  // of `own_`; in all
    std::uint64_t givenBack_ = 0;         // times
    std::mutex telling_;
    std::function<void()> tell_;  // under `telling_`
};

}  // namespace mote::server
