// SPDX-License-Identifier: GPL-3.0-or-later
//
// The rule by which a plot gets its bounds where the request gives none; in words in docs/FORMAT.md. Pure
// functions.
//
// The ranges of a step's plot coordinates by the rule of bounds_rule.h, found block by block.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/particles/step_reader.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// A closed range of values; empty where min > max.
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

/// Where values are taken for particles of the beam, from every n-th of them (finite): no further than 1000
/// interquartile ranges from the median. Where half of the values are the same, the ranges from 5 to 95% and
/// from 1 to 99% take the place of the quartiles'; where these are nothing too, all values count.
Range acceptedRange(std::vector<double> sample);

/// A range that is one value gets a width, the value in its middle. Errors: resourceExhausted, where the
/// range is too wide for a difference of its ends.
Result<Range> widened(Range range);

/// One pass, and another one or two where particles are left out. Empty ranges for a step without particles.
/// The same on all ranks, for any number of them. Errors: the source's own, cancelled.
Result<std::array<Range, 3>> stepBounds(StepReader& reader, Communicator& ranks);

}  // namespace mote::prep
