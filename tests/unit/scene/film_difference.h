// SPDX-License-Identifier: GPL-3.0-or-later
//
// How different two frames of a film are: a number that goes to zero as they come to show the same. Pure
// functions.
#pragma once

#include "protocol/scene/view.h"

namespace mote::test {

/// The largest difference of any number that both say; of what only one of them shows, how much of it there
/// is. Curves of equally many knots are compared by these, others by their values, on average.
double difference(const View& a, const View& b);

}  // namespace mote::test
