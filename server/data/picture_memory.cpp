// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/picture_memory.h"

#include <algorithm>

namespace mote::server {
namespace {

constexpr std::uint64_t small = std::uint64_t{16} << 20, leftToSmall = small;

}  // namespace

void PictureMemory::Taken::shrink(std::uint64_t bytes) {
    const std::uint64_t before = this->bytes();
    if (memory_ == nullptr || bytes >= before) return;
    const std::uint64_t own = std::min(own_, bytes);
    if (bytes - own != more_) {
        held_ = {};
        held_ = HeldMemory::of(memory_->data_, bytes - own);
        more_ = bytes - own;
    }
    const auto memory = bytes == 0 ? std::exchange(memory_, nullptr) : memory_;
    memory->giveBack(std::exchange(own_, own) - own, before - bytes);
}

void PictureMemory::Taken::leave() {
    if (const auto memory = std::exchange(memory_, nullptr)) {
        const std::uint64_t all = bytes(), own = std::exchange(own_, 0);
        more_ = 0;
        held_ = {};
        memory->giveBack(own, all, false);
    }
}

void PictureMemory::Taken::become(std::uint64_t bytes) {
    const std::uint64_t before = this->bytes();
    if (memory_ == nullptr || bytes <= before) return shrink(bytes);
    const std::lock_guard lock(memory_->mutex_);
    own_ += bytes - before;
    memory_->used_ += bytes - before;
    memory_->taken_ += bytes - before;
}

std::optional<PictureMemory::Taken> PictureMemory::take(std::uint64_t bytes) {
    if (bytes == 0) return Taken();
    const std::uint64_t limit = ownFor(bytes);
    std::uint64_t own = 0;
    {
        const std::lock_guard lock(mutex_);
        own = std::min(bytes, limit - std::min(used_, limit));
        used_ += own;
    }
    std::optional<HeldMemory> held;
    if (own == bytes)
        held.emplace();
    else if (data_)
        held = HeldMemory::whereThereIsRoom(data_, bytes - own);
    const std::lock_guard lock(mutex_);
    if (!held) {
        // Nobody is told: there is no more than before.
        used_ -= own;
        return std::nullopt;
    }
    taken_ += bytes;
    Taken taken;
    taken.memory_ = shared_from_this();
    taken.own_ = own;
    taken.more_ = bytes - own;
    taken.held_ = *std::move(held);
    return taken;
}

std::uint64_t PictureMemory::most(std::uint64_t bytes) const {
    return ownFor(bytes) + (data_ ? data_->limit() : 0);
}

/// Of its own part, what pictures of that size may take.
std::uint64_t PictureMemory::ownFor(std::uint64_t bytes) const {
    return bytes <= small ? own_ : own_ - std::min(own_, leftToSmall);
}

std::uint64_t PictureMemory::room() const {
    const std::lock_guard lock(mutex_);
    const std::uint64_t data = data_ ? data_->limit() - std::min(data_->resident(), data_->limit()) : 0;
    return own_ - std::min({own_, used_ + leftToSmall}) + data;
}

std::uint64_t PictureMemory::taken() const {
    const std::lock_guard lock(mutex_);
    return taken_;
}

std::uint64_t PictureMemory::givenBack() const {
    const std::lock_guard lock(mutex_);
    return givenBack_;
}

void PictureMemory::whenGivenBack(std::function<void()> tell) {
    const std::lock_guard lock(telling_);
    tell_ = std::move(tell);
}

void PictureMemory::giveBack(std::uint64_t own, std::uint64_t all, bool tells) {
    {
        const std::lock_guard lock(mutex_);
        used_ -= own;
        taken_ -= all;
        ++givenBack_;
    }
    const std::lock_guard lock(telling_);
    if (tells && tell_) tell_();
}

}  // namespace mote::server
