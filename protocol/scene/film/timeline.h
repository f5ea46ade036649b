// SPDX-License-Identifier: GPL-3.0-or-later
//
// Timeline: the view at each time of a film that is computed. Immutable; safe on any number of threads.
#pragma once

#include "protocol/mote.pb.h"

namespace mote {

class Timeline {
  public:
    virtual ~Timeline() = default;
    /// A valid view at any time; before the first and after the last what they are.
    virtual proto::View at(double seconds) const = 0;
    virtual double begin() const = 0;  ///< seconds, of its own clock
    virtual double end() const = 0;
};

}  // namespace mote
