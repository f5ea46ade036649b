// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which steps of a series are shown where a film is between two: one, or two neighbours at once. Pure
// functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace mote {

/// How a film goes from one step to the next.
enum class BetweenSteps {
    hold,   ///< a step is shown until the next
    blend,  ///< on the way from one to the next (Layer::towards)
};

struct ShownStep {
    std::uint32_t step;
    double weight;  ///< 0 to 1; of all that are shown together 1

    bool operator==(const ShownStep&) const = default;
};

/// Those at a place counted in steps from `from` towards `to`: 0 to their distance.
inline std::vector<ShownStep> stepsAt(std::uint32_t from, std::uint32_t to, double place,
                                      BetweenSteps between) {
    constexpr double rounding = 1e-9;  // a place that was meant to be a step's own
    const std::uint32_t distance = to > from ? to - from : from - to;
    const double whole = std::floor(std::clamp(place + rounding, 0.0, static_cast<double>(distance)));
    const auto passed = static_cast<std::uint32_t>(whole);
    const auto stepAfter = [&](std::uint32_t count) { return to > from ? from + count : from - count; };
    const double share = place - whole;
    if (between == BetweenSteps::hold || passed == distance || share <= rounding)
        return {{stepAfter(passed), 1.0}};
    return {{stepAfter(passed), 1.0 - share}, {stepAfter(passed + 1), share}};
}

/// On the way from one keyframe to another, each with a step of its own.
inline std::vector<ShownStep> stepsBetween(std::uint32_t from, std::uint32_t to, double share,
                                           BetweenSteps between) {
    return stepsAt(from, to, share * std::abs(static_cast<double>(to) - static_cast<double>(from)), between);
}

/// While all steps from one to another are played: each for as long as the others. What is blended has its
/// own in the middle of its time.
inline std::vector<ShownStep> stepsPlayed(std::uint32_t from, std::uint32_t to, double share,
                                          BetweenSteps between) {
    const double count = std::abs(static_cast<double>(to) - static_cast<double>(from)) + 1.0;
    const double place = share * count - (between == BetweenSteps::blend ? 0.5 : 0.0);
    return stepsAt(
        from, to, std::clamp(place, 0.0, count - 1.0 + (between == BetweenSteps::hold ? 0.5 : 0.0)), between);
}

}  // namespace mote
