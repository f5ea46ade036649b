// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/area_queue.h"

#include <numeric>

namespace mote::prep {

AreaQueue::AreaQueue(std::vector<double> areas)
    : areas_(std::move(areas)), heap_(areas_.size()), slot_(areas_.size()) {
    std::iota(heap_.begin(), heap_.end(), 0U);
    std::iota(slot_.begin(), slot_.end(), 0U);
    for (std::size_t slot = heap_.size() / 2; slot-- > 0;) sink(slot);
}

void AreaQueue::removeSmallest() {
    const auto last = heap_.back();
    heap_.pop_back();
    if (heap_.empty()) return;
    put(0, last);
    sink(0);
}

void AreaQueue::update(std::uint32_t point, double area) {
    const bool smaller = area < areas_[point];
    areas_[point] = area;
    if (smaller) {
        rise(slot_[point]);
    } else {
        sink(slot_[point]);
    }
}

void AreaQueue::rise(std::size_t slot) {
    const auto point = heap_[slot];
    while (slot > 0 && before(point, heap_[(slot - 1) / 2])) {
        put(slot, heap_[(slot - 1) / 2]);
        slot = (slot - 1) / 2;
    }
    put(slot, point);
}

void AreaQueue::sink(std::size_t slot) {
    const auto point = heap_[slot];
    for (std::size_t child = 2 * slot + 1; child < heap_.size(); child = 2 * slot + 1) {
        if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
        if (!before(heap_[child], point)) break;
        put(slot, heap_[child]);
        slot = child;
    }
    put(slot, point);
}

}  // namespace mote::prep
