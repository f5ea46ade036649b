// SPDX-License-Identifier: GPL-3.0-or-later
//
// The rule by which a plot gets its bounds if the request gives none; in words in docs/FORMAT.md. Pure
// functions.
//
// The ranges of a step's plot coordinates by the rule of bounds_rule.h, found block by block.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/particles/step_reader.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// A closed range of values; empty if min > max.
struct Range {
    double min = 1.0;
    double max = 0.0;

    bool empty() const { return min > max; }
    bool contains(double value) const { return value >= min && value <= max; }
    Range united(const Range& other) const;
    bool operator==(const Range&) const = default;
};

/// Quantiles of so many values are those of every n-th: 1 for at most 65,536 values.
std::uint64_t sampleStride(std::uint64_t values);

/// What all look at first: the middle of the values and the range around it in which none is strange.
struct CoreRange {
    Range near;
    double median = 0.0;
};

/// From every n-th value (finite): no further than 1000 interquartile ranges from the median. Where half of
/// the values are the same, the ranges from 5 to 95% and from 1 to 99% take the place of the quartiles';
/// where these are nothing too, all values.
CoreRange coreOf(std::vector<double> sample);

/// A value beyond that range.
struct FarValue {
    double value = 0.0;
    double weight = 0.0;
};

/// At most so many of so many particles are left out at each end of an axis: 3, or the ten-thousandth part.
std::uint64_t mostCut(std::uint64_t particles);

/// How many of the furthest values at one end are left out: those that lie by themselves, ten times further
/// than the next, and weigh at most a hundredth of all. `far` begins with the furthest and holds, of all that
/// are far, at least the `most` + 1 furthest; `next` is the furthest of the others, on either side.
std::size_t cutFrom(const std::vector<FarValue>& far, double median, double next, double totalWeight,
                    std::uint64_t most);

/// What the bounds of a step leave out on an axis.
struct Cut {
    std::uint64_t particles = 0;
    Range values;

    void add(const Cut& other) {
        particles += other.particles;
        values = values.united(other.values);
    }
};

struct StepBounds {
    std::array<Range, 3> ranges;  ///< empty if the step has no particle
    std::array<Cut, 3> cuts;
};

/// A range that is one value gets a width, the value in its middle. Errors: resourceExhausted, where the
/// range is too wide for a difference of its ends.
Result<Range> widened(Range range);

/// Finds them in one pass, and another one or two if particles are far from the others. The same on all
/// ranks, for any number of them. Errors: the source's own, cancelled.
Result<StepBounds> stepBounds(StepReader& reader, Communicator& ranks);

}  // namespace mote::prep
