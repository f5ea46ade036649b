// SPDX-License-Identifier: GPL-3.0-or-later
//
// How a column lies in its file: as floats beside an offset, or as the doubles that it is. Chosen from a
// sample of the points that are written. A value and pure functions.
//
// A float is coarse where it lies far from the offset. What is measured is not the column as a whole, which a
// second bunch far away makes wide, but wherever values are close: a step must be less than 1e-4 of the
// spread of what is as close as the closest hundredth of the values, and any eight that lie by themselves
// must have many steps among them. Values that floats hold exactly, as those of files in floats, are as they
// were.
#pragma once

#include <vector>

namespace mote::prep {

struct ColumnCoding {
    double offset = 0.0;   ///< a value is this plus a float
    bool doubles = false;  ///< instead: the values themselves
};

/// Chooses for coordinates. Values that are not finite have no say.
ColumnCoding codingOf(std::vector<double> sample);

/// Chooses for weights, whose sums are to be the source's: floats if these are exact, or hold the one weight
/// that all particles have; `least` and `greatest` are of all particles, not of the sample.
ColumnCoding weightCodingOf(const std::vector<double>& sample, double least, double greatest);

/// The step from a value to the next if what is stored is at most so far from 0.
double resolutionOf(const ColumnCoding& coding, double greatestStored);

}  // namespace mote::prep
