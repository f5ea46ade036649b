// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointMask: which points of a step are chosen, a bit each, in the order of ParticleStep's points. A value.
#pragma once

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
    std::uint64_t bytes() const { return words_.capacity() * sizeof(std::uint64_t); }
    bool operator==(const PointMask&) const = default;

  private:
    std::uint64_t points_ = 0;
    std::vector<std::uint64_t> words_;
};

}  // namespace mote::storage
