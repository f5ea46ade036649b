// SPDX-License-Identifier: GPL-3.0-or-later
//
// StartupLimits: how many connections may be there that have shown no token. A value.
#pragma once

#include <cstddef>
#include <functional>

namespace mote::server {

/// Up to `start` nobody is dropped; from there on one at the rate for each that comes, at `full` always.
struct StartupLimits {
    std::size_t start = 100;  ///< more than there are sessions: they all come back at once after a restart
    std::size_t full = 256;
    double rate = 0.3;

    /// How likely one is dropped where so many are there and one comes.
    double dropped(std::size_t pending) const;
};

/// Uniform in [0, 1).
using StartupRandom = std::function<double()>;

/// Of a generator that nobody can foresee.
StartupRandom uniformRandom();

}  // namespace mote::server
