// SPDX-License-Identifier: GPL-3.0-or-later
//
// Curves and colours of generated views: ramps, bands, steps, ties, zeros, ones, one knot and as many as
// there may be. Pure functions of the numbers that they draw.
#pragma once

#include <string>
#include <vector>

#include "protocol/scene/curve.h"
#include "protocol/scene/hybrid_style.h"
#include "tests/support/random.h"

namespace mote::test {

/// Ascending; x within the range, y within 0 to 1.
std::vector<Curve::Knot> anyKnots(Random& random, const ValueRange& range);

/// A share from 0 to 1, with a liking for the ends and what lies close to them.
double anyShare(Random& random);

void setAnyColor(Random& random, google::protobuf::RepeatedField<double>* color);
std::string anyColorMap(Random& random);

}  // namespace mote::test
