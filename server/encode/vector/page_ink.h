// SPDX-License-Identifier: GPL-3.0-or-later
//
// PageInk: what one pen draws on a sheet: lines of one width together, and filled areas, in pixels of the
// picture, which the writers place. Values; pure functions.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <vector>

#include "server/encode/vector/page_paths.h"
#include "server/render/plan/stroke.h"

namespace mote::server {

struct PageInk {
    std::string name;                   ///< of its layer
    glm::vec3 color{0.0F};              ///< sRGB-encoded
    glm::vec3 beneath{1.0F};            ///< sRGB-encoded: what it lies on, about, of a page without opacity
    double opacity = 1.0;               ///< of all of it together
    std::map<double, PagePaths> lines;  ///< by their width, pixels; with round ends and joints
    PagePaths outlines;                 ///< of lines of changing width, one each: all that they go around
    std::vector<PagePaths> areas;       ///< what an odd number of each one's closed paths surrounds
    std::vector<PageInk> parts;         ///< what is seen of the pen in other colours; they have no parts

    bool empty() const { return lines.empty() && outlines.size() == 0 && areas.empty(); }
};

/// A line's width becomes the nearest power of 2^(1/16), so that many lines make few paths. What lies outside
/// a picture of so many pixels is left out. `plotter`: each line has its mean width and a length, and lines
/// come in the order of a short tour; areas are their outlines, drawn as lines of a pixel.
PageInk inkOnPage(const render::Strokes& strokes, std::uint32_t width, std::uint32_t height, bool plotter);

}  // namespace mote::server
