// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointMask: which points of a step are chosen, a bit each, in the order of ParticleStep's points. A value.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mote::storage {

class PointMask {
  public:
    static constexpr std::uint64_t wordBits = 64;

    PointMask() = default;
    /// Of so many points, none of them chosen.
    explicit PointMask(std::uint64_t points) : points_(points), words_((points + wordBits - 1) / wordBits) {}

    std::uint64_t size() const { return points_; }
    bool chosen(std::uint64_t point) const {
        return ((words_[point / wordBits] >> (point % wordBits)) & 1U) != 0;
    }
    void choose(std::uint64_t point) { words_[point / wordBits] |= std::uint64_t{1} << (point % wordBits); }

    /// The point 64 i + b is bit b of word i; bits beyond the last point are 0, and whoever writes words
    /// keeps them so. Threads may write different words.
    std::vector<std::uint64_t>& words() { return words_; }
    const std::vector<std::uint64_t>& words() const { return words_; }

    std::uint64_t count() const {
        std::uint64_t sum = 0;
        for (const auto word : words_) sum += static_cast<std::uint64_t>(std::popcount(word));
        return sum;
    }
    /// Of the points [begin, end), end <= size().
    std::uint64_t count(std::uint64_t begin, std::uint64_t end) const {
        std::uint64_t sum = 0;
        while (begin < end) {
            const auto first = begin % wordBits, bits = std::min(wordBits - first, end - begin);
            const auto kept = bits < wordBits ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0};
            sum += static_cast<std::uint64_t>(std::popcount(words_[begin / wordBits] >> first & kept));
            begin += bits;
        }
        return sum;
    }
    std::uint64_t bytes() const { return words_.capacity() * sizeof(std::uint64_t); }
    bool operator==(const PointMask&) const = default;

  private:
    std::uint64_t points_ = 0;
    std::vector<std::uint64_t> words_;
};

}  // namespace mote::storage
