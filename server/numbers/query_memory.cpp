// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/query_memory.h"

#include <fmt/format.h>

#include <chrono>

namespace mote::server {
namespace {

constexpr std::chrono::milliseconds betweenLooks{5};
constexpr std::chrono::seconds patience{10};

}  // namespace

QueryMemory::Hold::~Hold() {
    if (memory_) memory_->giveBack(bytes_);
}

void QueryMemory::Hold::shrink(std::uint64_t bytes) {
    if (!memory_ || bytes >= bytes_) return;
    memory_->giveBack(bytes_ - bytes);
    bytes_ = bytes;
}

Result<QueryMemory::Hold> QueryMemory::take(std::uint64_t bytes, const std::function<bool()>& cancelled) {
    if (bytes > limit_) {
        return Error{
            ErrorCode::resourceExhausted, "",
            fmt::format("{} MiB would be needed to answer, and {} MiB may be used for queries; ask for "
                        "less at once, or start the server with more --memory",
                        (bytes >> 20) + 1, limit_ >> 20)};
    }
    {
        std::unique_lock lock(mutex_);
        const auto until = std::chrono::steady_clock::now() + patience;
        while (used_ + bytes > limit_) {
            if (cancelled && cancelled()) return Error{ErrorCode::cancelled, "", "cancelled"};
            if (std::chrono::steady_clock::now() > until) {
                return Error{
                    ErrorCode::resourceExhausted, "",
                    "other queries keep the memory that this one needs; ask again later, or start the "
                    "server with more --memory"};
            }
            freed_.wait_for(lock, betweenLooks);
        }
        used_ += bytes;
    }
    budget_->takeMakingRoom(bytes);
    return Hold(shared_from_this(), bytes);
}

QueryMemory::Hold QueryMemory::tryTake(std::uint64_t bytes) {
    {
        const std::lock_guard lock(mutex_);
        if (used_ + bytes > limit_) return {};
        used_ += bytes;
    }
    budget_->takeMakingRoom(bytes);
    return Hold(shared_from_this(), bytes);
}

void QueryMemory::giveBack(std::uint64_t bytes) {
    {
        const std::lock_guard lock(mutex_);
        used_ -= bytes;
    }
    budget_->giveBack(bytes);
    freed_.notify_all();
}

}  // namespace mote::server
