// SPDX-License-Identifier: GPL-3.0-or-later
//
// QueryMemory: what queries may take together besides the blocks of columns: masks, tables, ids, answers that
// wait to be sent. It is part of what data may take (storage/blocks/block_budget.h): blocks make room for it.
// Any thread.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>

#include "protocol/base/error.h"
#include "storage/blocks/block_budget.h"

namespace mote::server {

class QueryMemory : public std::enable_shared_from_this<QueryMemory> {
  public:
    /// Some of it, given back at the end. Move-only.
    class Hold {
      public:
        Hold() = default;
        Hold(Hold&& other) noexcept { swap(other); }
        Hold& operator=(Hold&& other) noexcept {
            Hold(std::move(other)).swap(*this);
            return *this;
        }
        ~Hold();
        std::uint64_t bytes() const { return bytes_; }
        /// Gives back all but so many bytes.
        void shrink(std::uint64_t bytes);

      private:
        friend class QueryMemory;
        Hold(std::shared_ptr<QueryMemory> memory, std::uint64_t bytes)
            : memory_(std::move(memory)), bytes_(bytes) {}
        void swap(Hold& other) noexcept {
            std::swap(memory_, other.memory_);
            std::swap(bytes_, other.bytes_);
        }

        std::shared_ptr<QueryMemory> memory_;
        std::uint64_t bytes_ = 0;
    };

    QueryMemory(std::shared_ptr<storage::BlockBudget> budget, std::uint64_t limit)
        : budget_(std::move(budget)), limit_(limit) {}

    std::uint64_t limit() const { return limit_; }
    /// Waits until others have given back enough; `cancelled` is asked every few milliseconds. Errors:
    /// resourceExhausted, if it is more than there can be, or others keep it for long; cancelled.
    Result<Hold> take(std::uint64_t bytes, const std::function<bool()>& cancelled);
    /// Only if it is there at once: a hold of no bytes else.
    Hold tryTake(std::uint64_t bytes);

  private:
    void giveBack(std::uint64_t bytes);

    const std::shared_ptr<storage::BlockBudget> budget_;
    const std::uint64_t limit_;
    std::mutex mutex_;
    std::condition_variable freed_;
    std::uint64_t used_ = 0;  // under the mutex
};

}  // namespace mote::server
