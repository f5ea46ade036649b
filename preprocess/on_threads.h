// SPDX-License-Identifier: GPL-3.0-or-later
//
// Work on as many threads as a job was given, in parallel, and on a series in two stages. Functions without
// state.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "protocol/base/error.h"

namespace mote::prep {

/// What went wrong first on any of several threads. set() may be called from any thread.
class FirstError {
  public:
    void set(const Error& error) {
        const std::lock_guard lock(mutex_);
        if (status_.ok()) status_ = error;
    }
    /// Once the others are done.
    const Status& status() const { return status_; }

  private:
    std::mutex mutex_;
    Status status_ = success();
};

/// What `work` returns; oneTBB's loops in it take `threads`, 0: as many as there are cores.
template <class Work>
auto onThreads(int threads, const Work& work) {
    std::optional<tbb::global_control> more;
    // More threads than cores only if asked for: the library stops at the cores otherwise.
    if (threads > 0) {
        more.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    }
    tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
    return arena.execute(work);
}

/// Calls `work(i)`, which gives a Status, for each i below `count`, on all threads of the calling arena.
/// Returns the first error in the order of i; the others are done nevertheless.
template <class Work>
Status inParallel(std::size_t count, const Work& work) {
    std::vector<Status> all(count, success());
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { all[i] = work(i); });
    for (const auto& status : all) MOTE_RETURN_IF_ERROR(status);
    return success();
}

/// The second stage of one item runs beside the first of the next. Each stage takes the items one at a time
/// and in their order, so that what it leaves is the same as if they came one after another. Uses the threads
/// of the calling arena. `first(i)` gives a Result, whose value `second(i, value)` takes and returns a
/// Status. `together`: at most so many items are under way. Returns the first error; nothing is begun after
/// it.
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
