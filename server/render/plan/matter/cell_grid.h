// SPDX-License-Identifier: GPL-3.0-or-later
//
// CellGrid: the cells of one level of an octree within a box, x fastest. A value; its functions are pure.
#pragma once

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "server/render/plan/octree_cell.h"

namespace mote::render {

/// Where an octree's cell lies: its level, at most the deepest, and its place among those of the level.
struct CellAt {
    unsigned level;
    glm::uvec3 place;

    CellAt(std::uint8_t nodeLevel, std::uint64_t morton)
        : level(std::min<unsigned>(nodeLevel, deepestLevel)), place(cellPlace(morton)) {}
};

struct CellGrid {
    unsigned level = 0;
    glm::uvec3 low{0}, high{0};  ///< its cells: from the first to before the last, along each axis

    /// The cells of a level around [low, high) of the deepest one, and one more on each side.
    static CellGrid around(const glm::uvec3& low, const glm::uvec3& high, unsigned level) {
        const glm::uvec3 shift(deepestLevel - level);
        CellGrid grid{level, low >> shift, ((high - 1U) >> shift) + 1U};
        grid.low -= glm::min(grid.low, glm::uvec3(1));
        grid.high = glm::min(grid.high + 1U, glm::uvec3(1U << level));
        return grid;
    }

    glm::uvec3 size() const { return high - low; }
    std::uint64_t count() const { return std::uint64_t{size().x} * size().y * size().z; }
    std::size_t index(const glm::uvec3& cell) const {
        const glm::uvec3 at = cell - low;
        return (std::size_t{at.z} * size().y + at.y) * size().x + at.x;
    }

    /// Calls visit(index, share of the cell) for each cell that another level's cell lies in.
    template <class Visit>
    void forCells(const CellAt& other, const Visit& visit) const {
        const unsigned down = other.level > level ? other.level - level : 0;
        const unsigned up = level > other.level ? level - other.level : 0;
        const glm::uvec3 from = (other.place >> glm::uvec3(down)) << glm::uvec3(up);
        const double part = cellShare(down);
        forBox(glm::max(from, low), glm::min(from + (1U << up), high),
               [&](const glm::uvec3& cell) { visit(index(cell), part); });
    }

    /// Where the middle of another level's cell lies in its cell, in cells from the cell's centre; of a
    /// larger one, in all of its cells.
    glm::dvec3 placeInCell(const CellAt& other) const {
        if (other.level <= level) return glm::dvec3(0.0);
        const unsigned side = 1U << (other.level - level);
        return (glm::dvec3(other.place & glm::uvec3(side - 1U)) + 0.5) / static_cast<double>(side) - 0.5;
    }

    /// Calls visit(index) for the cells around one, and for itself.
    template <class Visit>
    void forAround(const glm::uvec3& cell, const Visit& visit) const {
        forBox(glm::max(cell, low + 1U) - 1U, glm::min(cell + 2U, high),
               [&](const glm::uvec3& near) { visit(index(near)); });
    }

    /// Calls visit(cell, index) for each, on all threads of the calling arena.
    template <class Visit>
    void forEach(const Visit& visit) const {
        tbb::parallel_for(low.z, high.z, [&](std::uint32_t z) {
            forBox({low.x, low.y, z}, {high.x, high.y, z + 1},
                   [&](const glm::uvec3& cell) { visit(cell, index(cell)); });
        });
    }

  private:
    template <class Visit>
    static void forBox(const glm::uvec3& from, const glm::uvec3& to, const Visit& visit) {
        for (std::uint32_t z = from.z; z < to.z; ++z) {
            for (std::uint32_t y = from.y; y < to.y; ++y) {
                for (std::uint32_t x = from.x; x < to.x; ++x) visit(glm::uvec3(x, y, z));
            }
        }
    }
};

}  // namespace mote::render
