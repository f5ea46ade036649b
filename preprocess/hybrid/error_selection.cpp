// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/error_selection.h"

#include <limits>

namespace mote::prep {
namespace {

/// Ascends with the magnitude: floats without their sign are in the order of their bits.
std::uint32_t keyOf(float error) {
    return std::bit_cast<std::uint32_t>(std::abs(error));
}

}  // namespace

void ErrorCount::add(std::span<const float> errors) {
    constexpr std::uint32_t mask = (1U << lowerBits) - 1;
    for (const float error : errors) {
        const auto key = keyOf(error);
        if (key == 0) continue;
        if (!lower_) ++bins_[key >> lowerBits];
        if (lower_ && key >> lowerBits == upper_) ++bins_[key & mask];
    }
}

void ErrorCount::add(std::span<const std::uint64_t> bins) {
    for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += bins[i];
}

ErrorCount::Place ErrorCount::find(std::uint64_t most) const {
    Place place;
    for (auto bin = bins_.size(); bin-- > 0;) {
        if (place.above + bins_[bin] > most || (place.above + bins_[bin] == most && bins_[bin] > 0)) {
            place.bin = static_cast<std::uint32_t>(bin);
            return place;
        }
        place.above += bins_[bin];
    }
    place.fewer = true;
    return place;
}

ErrorSelection selectGreatest(const ErrorCount& lower, std::uint32_t upper, std::uint64_t most,
                              std::uint64_t above) {
    const auto place = lower.find(most - above);
    const auto key = upper << ErrorCount::lowerBits | place.bin;
    const float least = std::bit_cast<float>(key);
    return {std::nextafter(least, 0.0F), least, most - above - place.above};
}

}  // namespace mote::prep
