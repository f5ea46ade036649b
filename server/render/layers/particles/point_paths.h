// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointPaths: the ways of some particles through all steps of a run (docs/PICTURE.md, "Paths"). A value.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace mote::render {

struct PointPaths {
    std::vector<glm::dvec3> places;    ///< layer space
    std::vector<std::uint32_t> begin;  ///< of each way among the places, and the end of the last

    std::size_t size() const { return begin.empty() ? 0 : begin.size() - 1; }
    std::uint64_t bytes() const {
        return places.capacity() * sizeof(glm::dvec3) + begin.capacity() * sizeof(std::uint32_t);
    }
};

}  // namespace mote::render
