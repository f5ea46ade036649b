// SPDX-License-Identifier: GPL-3.0-or-later
//
// Ticks: where an axis has ticks and what stands beside them: round numbers in a unit with a prefix, with no
// more digits than tell them apart. A value; pure functions, any thread.
//
// A label times 10^power, plus the offset, is the tick's value in the unit: the labels are made of whole
// numbers and so are right to the last digit. An offset is taken if a range is so small against where it
// lies that labels would have more than five digits: "z − 12.345 m (µm)".
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "server/figures/rich_text.h"

namespace mote::server {

struct Tick {
    double value = 0.0;  ///< in the unit
    RichText label;
};

struct Ticks {
    std::vector<Tick> major;    ///< in the order of the axis; within its ends
    std::vector<double> minor;  ///< between them
    std::string unit;           ///< as it was given
    int prefix = 0;             ///< the power of ten that the unit's prefix stands for
    int power = 0;        ///< of what a label's number is multiplied with; the prefix' unless a power stands
                          ///< beside the unit
    double offset = 0.0;  ///< in the unit
    RichText offsetText;  ///< "12.345 m"; nothing without

    /// What the axis says: "name (keV/c)", "name − 12.345 m (µm)", "name (10^−3)".
    RichText title(const RichText& name) const;
};

/// Even ticks of a range, at most `most` of them, at least one if the ends are equal; of a range from high
/// to low they descend. If there are none within the range, as in one of which `most` is 1, none. Errors:
/// invalidArgument (an end that is not finite).
Result<Ticks> linearTicks(double low, double high, std::string_view unit, int most);

/// Ticks at powers of ten; if fewer than two are within the range, also between them. Errors:
/// invalidArgument (an end that is not finite or not above 0).
Result<Ticks> logTicks(double low, double high, std::string_view unit, int most);

}  // namespace mote::server
