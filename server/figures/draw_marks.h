// SPDX-License-Identifier: GPL-3.0-or-later
//
// Draws marks by Cairo, in the coordinates of its context: in pixels and on paper alike. One thread.
#pragma once

#include <cairo.h>

#include "server/figures/marks.h"
#include "server/figures/typeface.h"

namespace mote::server {

/// How text gets onto a surface.
enum class TextAs {
    outlines,  ///< areas, at any place and not at whole pixels
    text,      ///< of an embedded font, so that a document can be searched and edited
};

void drawMarks(cairo_t* context, const Marks& marks, const Typeface& typeface, TextAs textAs);

/// The same marks without transparency, as they are on a background, sRGB-encoded: for PostScript.
Marks flattened(Marks marks, const glm::dvec3& background);

}  // namespace mote::server
