// SPDX-License-Identifier: GPL-3.0-or-later
//
// The words of a frame: its title, and of each layer what it shows. Functions that add marks.
#pragma once

#include <string>
#include <vector>

#include "server/figures/annotate.h"
#include "server/figures/annotation_room.h"

namespace mote::server {

/// Along the upper edge, in the middle, as much of it as has room.
void addTitle(const std::string& title, AnnotationRoom& room);
/// In the upper left corner: dataset, step, time, and how many particles a selection holds. Lines for which
/// there is no room are left out.
void addWords(const View& view, const std::vector<LayerFacts>& layers, AnnotationRoom& room);

/// "1 234 567", in groups of three from 10000 on.
std::string groupedNumber(std::uint64_t number);

}  // namespace mote::server
