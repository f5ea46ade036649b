// SPDX-License-Identifier: GPL-3.0-or-later
//
// RemovalQueue: points by the area of their cells, the smallest first, of equals the one of the lower number.
// Areas change as points move. A binary heap that knows where each point stands in it; one thread.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace mote::prep {

class RemovalQueue {
  public:
    /// Points 0 to areas.size(), square world units.
    explicit RemovalQueue(std::vector<float> areas) : areas_(std::move(areas)), places_(areas_.size()) {
        heap_.resize(areas_.size());
        for (std::uint32_t i = 0; i < heap_.size(); ++i) heap_[i] = places_[i] = i;
        for (auto i = static_cast<std::uint32_t>(heap_.size() / 2); i-- > 0;) sink(i);
    }

    bool empty() const { return heap_.empty(); }
    std::size_t size() const { return heap_.size(); }
    float area(std::uint32_t point) const { return areas_[point]; }

    /// Takes the smallest out.
    std::uint32_t take() {
        const auto point = heap_.front();
        const auto last = heap_.back();
        heap_.pop_back();
        if (!heap_.empty()) {
            put(0, last);
            sink(0);
        }
        places_[point] = out;
        return point;
    }
    /// Puts one back that was taken.
    void putBack(std::uint32_t point) {
        heap_.push_back(point);
        put(static_cast<std::uint32_t>(heap_.size() - 1), point);
        rise(places_[point]);
    }
    /// Changes the area of a point that is in it.
    void setArea(std::uint32_t point, float area) {
        areas_[point] = area;
        rise(places_[point]);
        sink(places_[point]);
    }

  private:
    static constexpr std::uint32_t out = UINT32_MAX;

    bool before(std::uint32_t a, std::uint32_t b) const {
        return areas_[a] != areas_[b] ? areas_[a] < areas_[b] : a < b;
    }
    void put(std::uint32_t place, std::uint32_t point) {
        heap_[place] = point;
        places_[point] = place;
    }
    void rise(std::uint32_t place) {
        const auto point = heap_[place];
        while (place > 0 && before(point, heap_[(place - 1) / 2])) {
            put(place, heap_[(place - 1) / 2]);
            place = (place - 1) / 2;
        }
        put(place, point);
    }
    void sink(std::uint32_t place) {
        const auto point = heap_[place];
        for (;;) {
            std::size_t child = 2 * static_cast<std::size_t>(place) + 1;
            if (child >= heap_.size()) break;
            if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
            if (!before(heap_[child], point)) break;
            put(place, heap_[child]);
            place = static_cast<std::uint32_t>(child);
        }
        put(place, point);
    }

    std::vector<float> areas_;
    std::vector<std::uint32_t> heap_;    ///< points
    std::vector<std::uint32_t> places_;  ///< in heap_, by point
};

}  // namespace mote::prep
