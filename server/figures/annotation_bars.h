// SPDX-License-Identifier: GPL-3.0-or-later
//
// The bars of a frame: of colours, and of scale. Functions that add marks.
#pragma once

#include <vector>

#include "server/figures/annotate.h"
#include "server/figures/annotation_room.h"

namespace mote::server {

/// On the right, one above another: for each volume that is seen and for each column that colours points, one
/// that several layers share once. A plot's densities have their true scale: weight over what its axes span.
void addColorBars(const View& view, const std::vector<LayerFacts>& layers, AnnotationRoom& room);

/// In the lower left corner, where a layer that is no plot lies in the world's units: a round length of at
/// most a quarter of the picture's width, true at the depth of the camera's target.
void addScaleBar(const View& view, const std::vector<LayerFacts>& layers, AnnotationRoom& room);

}  // namespace mote::server
