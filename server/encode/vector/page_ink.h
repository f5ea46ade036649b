// SPDX-License-Identifier: GPL-3.0-or-later
//
// PageInk: what one pen draws on a sheet: lines of one width together, and filled areas, in pixels of the
// picture, which the writers place. Values; pure functions.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "server/render/plan/stroke.h"

namespace mote::server {

/// Ways through points, one after another.
struct PagePaths {
    std::vector<glm::dvec2> points;   ///< pixels
    std::vector<std::uint32_t> ends;  ///< of each path, behind its last point

    std::size_t size() const { return ends.size(); }
    std::span<const glm::dvec2> of(std::size_t path) const {
        const std::uint32_t begin = path == 0 ? 0 : ends[path - 1];
        return std::span(points).subspan(begin, ends[path] - begin);
    }
    void add(std::span<const glm::dvec2> path) {
        points.insert(points.end(), path.begin(), path.end());
        ends.push_back(static_cast<std::uint32_t>(points.size()));
    }
};

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
