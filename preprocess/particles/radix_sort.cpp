// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/radix_sort.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <utility>

namespace mote::prep {
namespace {

// 1024 open write positions fit the first-level cache and its address translation; 30 bits (level 10) are
// three passes.
constexpr unsigned digitBits = 10;
constexpr std::size_t digits = std::size_t{1} << digitBits;
constexpr std::size_t blockSize = std::size_t{1} << 18;

using Histogram = std::array<std::size_t, digits>;

std::size_t digitOf(std::uint64_t key, unsigned shift) {
    return (key >> shift) & (digits - 1);
}

class Pass {
  public:
    Pass(const KeyedIndices& from, KeyedIndices& to, unsigned shift)
        : from_(from), to_(to), shift_(shift), blocks_((from.key.size() + blockSize - 1) / blockSize) {}

    /// False where all keys have the same digit and nothing was moved.
    bool run() {
        tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t block) { count(block); });
        if (!place()) return false;
        tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t block) { scatter(block); });
        return true;
    }

  private:
    std::size_t endOf(std::size_t block) const { return std::min(from_.key.size(), (block + 1) * blockSize); }

    void count(std::size_t block) {
        blocks_[block].fill(0);
        for (std::size_t i = block * blockSize; i < endOf(block); ++i)
            ++blocks_[block][digitOf(from_.key[i], shift_)];
    }

    /// Turns counts into first places: by digit, then by block.
    bool place() {
        std::size_t at = 0;
        for (std::size_t digit = 0; digit < digits; ++digit) {
            const std::size_t begin = at;
            for (auto& block : blocks_) at += std::exchange(block[digit], at);
            if (at - begin == from_.key.size()) return false;
        }
        return true;
    }

    void scatter(std::size_t block) {
        auto& next = blocks_[block];
        for (std::size_t i = block * blockSize; i < endOf(block); ++i) {
            const std::size_t to = next[digitOf(from_.key[i], shift_)]++;
            to_.key[to] = from_.key[i];
            to_.index[to] = from_.index[i];
        }
    }

    const KeyedIndices& from_;
    KeyedIndices& to_;
    unsigned shift_;
    std::vector<Histogram> blocks_;
};

}  // namespace

void radixSort(KeyedIndices& items, unsigned bits) {
    if (items.key.size() < 2) return;
    KeyedIndices other;
    other.key.resize(items.key.size());
    other.index.resize(items.key.size());
    for (unsigned shift = 0; shift < bits; shift += digitBits) {
        if (Pass(items, other, shift).run()) std::swap(items, other);
    }
}

}  // namespace mote::prep
