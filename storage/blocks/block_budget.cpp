// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/blocks/block_budget.h"

#include <algorithm>

#include "storage/hash.h"

namespace mote::storage {
namespace {

/// More room than is asked for, so that not every block that comes looks at all that are there.
constexpr std::uint64_t slackShare = 64;  // of the budget
constexpr std::uint64_t mostSlack = std::uint64_t{16} << 20;
constexpr std::size_t batch = 32;  // blocks

}  // namespace

void BlockBudget::enter(const BudgetedBlocks& blocks) {
    const std::lock_guard lock(mutex_);
    owners_.push_back(&blocks);
}

void BlockBudget::leave(const BudgetedBlocks& blocks) {
    const std::lock_guard lock(mutex_);
    std::erase(owners_, &blocks);
    for (std::size_t block = 0; block < blocks.blockCount(); ++block) {
        if (blocks.usedIn(block) != 0) resident_ -= blocks.blockSize(block);
    }
}

/// Under the mutex.
std::vector<BlockBudget::Candidate> BlockBudget::oldest(Generation before, std::size_t most) const {
    std::vector<Candidate> found;
    for (const auto* owner : owners_) {
        for (std::size_t block = 0; block < owner->blockCount(); ++block) {
            const Generation used = owner->usedIn(block);
            if (used != 0 && used < before) found.push_back({used, block, owner});
        }
    }
    const auto older = [](const Candidate& a, const Candidate& b) {
        return a.used != b.used ? a.used < b.used : a.block > b.block;
    };
    const std::size_t count = std::min(most, found.size());
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count), found.end(), older);
    found.resize(count);
    return found;
}

/// Takes them of the room that there is; false if that is not enough.
bool BlockBudget::takeFree(std::uint64_t bytes, std::uint64_t limit) {
    auto resident = resident_.load(std::memory_order_relaxed);
    while (resident + bytes <= limit) {
        if (resident_.compare_exchange_weak(resident, resident + bytes, std::memory_order_relaxed))
            return true;
    }
    return false;
}

bool BlockBudget::take(std::uint64_t bytes, Generation generation) {
    if (takeFree(bytes, limit_)) return true;
    const std::uint64_t slack = std::min(limit_ / slackShare / blockBytes * blockBytes, mostSlack);
    const auto over = [&] { return resident() + bytes + slack > limit_; };
    const std::lock_guard lock(mutex_);
    for (;;) {
        const auto candidates = oldest(generation, batch);
        for (const auto& one : candidates) {
            // One that was used meanwhile stays.
            if (over()) giveBack(one.owner->giveUp(one.block, one.used));
        }
        if (over() && !candidates.empty()) continue;
        // What became free may have gone to another thread: then there is more to give up, or nothing.
        if (takeFree(bytes, limit_)) return true;
        if (candidates.empty()) return takeFree(bytes, limit_ + stillHeld_.load(std::memory_order_relaxed));
    }
}

}  // namespace mote::storage
