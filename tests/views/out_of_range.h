// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views that must be refused: a legal one in which one field is beyond its ends, is no number, or has too few
// or too many parts. Pure functions of the numbers that they draw.
#pragma once

#include <string>

#include "protocol/mote.pb.h"
#include "tests/support/random.h"

namespace mote::test {

struct Fault {
    std::string what;  ///< for a failing test: "layers[2].hybrid.point_size = nan"
    proto::View view;  ///< with it
};

/// One of the numbers that a view holds becomes NaN or infinite. A view without numbers gets a background.
Fault withoutANumber(Random& random, const proto::View& view);

/// One of the faults that the schema names, of those that the view has room for.
Fault beyondItsEnds(Random& random, const proto::View& view);

}  // namespace mote::test
