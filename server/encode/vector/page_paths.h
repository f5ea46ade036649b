// SPDX-License-Identifier: GPL-3.0-or-later
//
// PagePaths: ways through points of a picture, for the writers of sheets. A value.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

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

}  // namespace mote::server
