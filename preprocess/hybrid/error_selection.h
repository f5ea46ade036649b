// SPDX-License-Identifier: GPL-3.0-or-later
//
// ErrorSelection: which errors count: those above a threshold, or the M of greatest magnitude. The latter are
// found without sorting, by two counts: of the upper bits of all magnitudes, then of the lower bits of those
// that share the upper bits of the M-th (a radix selection). Values; counts have one thread at a time.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace mote::prep {

struct ErrorSelection {
    float threshold = 0.0F;  ///< errors of a greater magnitude count
    /// Only so many errors of the least magnitude that counts, `least`, count: the first in the order of the
    /// bricks.
    float least = 0.0F;
    std::uint64_t mostOfLeast = ~std::uint64_t{0};

    bool takes(float error) const { return std::abs(error) > threshold; }
};

class ErrorCount {
  public:
    static constexpr int lowerBits = 15;

    /// Counts upper bits.
    ErrorCount() : bins_(std::size_t{1} << (31 - lowerBits)) {}
    /// Counts lower bits of the magnitudes that have these upper bits.
    explicit ErrorCount(std::uint32_t upper)
        : lower_(true), upper_(upper), bins_(std::size_t{1} << lowerBits) {}

    /// One that counts the same, and has counted nothing.
    ErrorCount empty() const { return lower_ ? ErrorCount(upper_) : ErrorCount(); }

    /// Errors of zero do not count.
    void add(std::span<const float> errors);
    void add(std::span<const std::uint64_t> bins);
    std::span<const std::uint64_t> bins() const { return bins_; }

    /// Where the `most`-th greatest lies.
    struct Place {
        std::uint32_t bin = 0;
        std::uint64_t above = 0;  ///< in greater bins
        bool fewer = false;       ///< there are not more than `most`: all count
    };
    Place find(std::uint64_t most) const;

  private:
    bool lower_ = false;
    std::uint32_t upper_ = 0;
    std::vector<std::uint64_t> bins_;
};

/// Selects the `most` greatest: the least of them has the upper bits `upper`, `above` of them greater ones.
ErrorSelection selectGreatest(const ErrorCount& lower, std::uint32_t upper, std::uint64_t most,
                              std::uint64_t above);

}  // namespace mote::prep
