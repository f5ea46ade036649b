// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines without needless points. Pure.
#pragma once

#include <vector>

#include "server/render/ink/ink_line.h"

namespace mote::render {

/// Leaves out points that lie within an eighth of a pixel of the way between others, where the depth steps
/// beside the line stay alike. `points`: at least two.
void simplify(std::vector<LinePoint>& points);

}  // namespace mote::render
