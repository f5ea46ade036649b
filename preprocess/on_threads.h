// SPDX-License-Identifier: GPL-3.0-or-later
//
// Work on as many threads as a job was given. A function without state.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <cstddef>
#include <optional>

namespace mote::prep {

/// What `work` returns; oneTBB's loops in it take `threads`, 0: as many as there are cores.
template <class Work>
auto onThreads(int threads, const Work& work) {
    std::optional<tbb::global_control> more;
    // More threads than cores only where asked for: the library stops at the cores otherwise.
    if (threads > 0) {
        more.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    }
    tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
    return arena.execute(work);
}

}  // namespace mote::prep
