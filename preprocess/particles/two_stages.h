// SPDX-License-Identifier: GPL-3.0-or-later
//
// Work on a series in two stages: the second of one item beside the first of the next. Each stage takes the
// items one at a time and in their order, so that what it leaves is the same as if they came one after
// another. Uses the threads of the calling arena.
#pragma once

#include <oneapi/tbb/parallel_pipeline.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>

#include "protocol/scene/error.h"

namespace mote::prep {

/// `first(i)` gives a Result, whose value `second(i, value)` takes and returns a Status. `together`: at most
/// so many items are under way. Returns the first error; nothing is begun after it.
template <class First, class Second>
Status inTwoStages(std::size_t count, std::size_t together, First first, Second second) {
    using Made = decltype(first(std::size_t{0}));
    struct Item {
        std::size_t index;
        Made made;
    };
    std::size_t next = 0;
    Status status = success();  // of the second stage; the first learns of it a little later
    std::atomic<bool> stopped{false};
    const auto begin = [&](tbb::flow_control& control) -> std::shared_ptr<Item> {
        if (next == count || stopped) {
            control.stop();
            return nullptr;
        }
        const std::size_t index = next++;
        auto item = std::make_shared<Item>(Item{index, first(index)});
        if (!item->made.ok()) stopped = true;
        return item;
    };
    const auto end = [&](const std::shared_ptr<Item>& item) {
        if (!status.ok()) return;
        status = item->made.ok() ? second(item->index, *std::move(item->made)) : Status(item->made.error());
        if (!status.ok()) stopped = true;
    };
    tbb::parallel_pipeline(
        together, tbb::make_filter<void, std::shared_ptr<Item>>(tbb::filter_mode::serial_in_order, begin) &
                      tbb::make_filter<std::shared_ptr<Item>, void>(tbb::filter_mode::serial_in_order, end));
    return status;
}

}  // namespace mote::prep
