// SPDX-License-Identifier: GPL-3.0-or-later
//
// thinPlane: from even points to a hierarchy: again and again the point with the smallest Voronoi cell is
// removed, and its neighbours move by Lloyd's method with everything else fixed (dissertation 2.2.2.1). What
// it records its moves in serves surfaces too. One owner and one thread each.
#pragma once

#include <cstdint>
#include <deque>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::prep {

/// Points by the area of their cells, the smallest first, of equals the one with the smaller
/// index. A binary heap that knows where each point is in it. A value; one thread.
class AreaQueue {
  public:
    /// Holds all points with their areas.
    explicit AreaQueue(std::vector<double> areas);

    bool empty() const { return heap_.empty(); }
    std::uint32_t smallest() const { return heap_.front(); }
    double area(std::uint32_t point) const { return areas_[point]; }
    void removeSmallest();
    /// Changes the area of a point that is in it.
    void update(std::uint32_t point, double area);

  private:
    bool before(std::uint32_t a, std::uint32_t b) const {
        return areas_[a] < areas_[b] || (areas_[a] == areas_[b] && a < b);
    }
    void put(std::size_t slot, std::uint32_t point) {
        heap_[slot] = point;
        slot_[point] = static_cast<std::uint32_t>(slot);
    }
    void rise(std::size_t slot);
    void sink(std::size_t slot);

    std::vector<double> areas_;
    std::vector<std::uint32_t> heap_;
    std::vector<std::uint32_t> slot_;  ///< each point's place in heap_
};

/// The schema has its defaults (thinningOptions).
struct ThinningOptions {
    ThinningOptions(int ringsOf, double times) : rings(ringsOf), relaxation(times) {}
    int rings;          ///< of neighbours that move at a removal, 1 or 2; 0: a static hierarchy
    double relaxation;  ///< times the way to the centroid of the cell
};

/// `points` lie on the periodic unit square, no two alike; at least one. One thread. Reports progress from
/// `begin` to 1. Errors: cancelled.
Result<storage::StippleHierarchy> thinPlane(const std::vector<glm::dvec2>& points,
                                            const ThinningOptions& options, double begin, Progress& progress);

struct RecordedMove {
    std::uint32_t point;
    std::uint32_t neighbour;  ///< the removed point that caused it
    glm::vec3 position;       ///< where it leads, world units
};

using RecordedMoves = std::deque<RecordedMove>;  ///< grows without being copied

/// Puts them into a hierarchy that has its points, by point, each point's in their order.
void storeMoves(const RecordedMoves& moves, storage::StippleHierarchy& hierarchy);

}  // namespace mote::prep
