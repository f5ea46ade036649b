// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is seen of a pen's strokes on a page: lines and areas cut where what lies before them changes, each
// piece with its colour, without those that are hidden. Pure functions.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "server/encode/vector/shape_places.h"
#include "server/encode/vector/sight.h"
#include "server/render/plan/stroke.h"

namespace mote::server {

/// Pieces by their colour (linear RGB, with what lies before them): first, though it be empty, those before
/// which nothing lies, in the pen's; the others to a 64th of encoded colours. `plotter`: all in the pen's, of
/// that of which half comes through; an area of which as much does stays whole.
std::vector<render::Strokes> seenOf(const render::Strokes& strokes, const Sight& sight,
                                    const PictureSize& size, bool plotter);

}  // namespace mote::server
