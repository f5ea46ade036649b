// SPDX-License-Identifier: GPL-3.0-or-later
//
// A dataset whose files somebody rewrites, cuts off and puts back in place while it is read, drawn and
// counted. A function that makes threads of its own.
#pragma once

#include <cstdint>

#include "tests/unit/damage/damaged_dataset.h"

namespace mote::test {

/// Asks so many questions, each of a dataset that is as it was made when it is asked; meanwhile a thread
/// changes some of it, a little earlier or later. The dataset counts the answers. Returns how often it was
/// changed.
std::uint64_t askWhileRewritten(DamagedDataset& dataset, std::uint64_t questions, std::uint64_t seed);

}  // namespace mote::test
