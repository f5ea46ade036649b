// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pens that draw the dots of a page: one a colour, those behind first, unless they are too many or none
// of them could be drawn before another without covering what lies in front. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "server/render/plan/dot.h"

namespace mote::server {

struct DotPen {
    std::string name;               ///< of its layer
    std::vector<std::size_t> dots;  ///< those behind first: of equal depth, the earlier lies in front
};

/// `plotter`: pens are colours whatever they cover.
std::vector<DotPen> pensOf(const render::Dots& dots, bool plotter);

}  // namespace mote::server
