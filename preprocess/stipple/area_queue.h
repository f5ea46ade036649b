// SPDX-License-Identifier: GPL-3.0-or-later
//
// AreaQueue: points by the area of their cells, the smallest first, of equals the one with the smaller index.
// A binary heap that knows where each point is in it. A value; one thread.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace mote::prep {

class AreaQueue {
  public:
    /// All points with their areas.
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

}  // namespace mote::prep
