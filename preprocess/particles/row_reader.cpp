// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/row_reader.h"

#include <oneapi/tbb/concurrent_queue.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "protocol/scene/mote_check.h"

namespace mote::prep {

Status forEachChunk(ParticleSource& source, std::size_t step, std::uint64_t begin, std::uint64_t end,
                    const std::vector<Column>& wanted, const Progress& progress,
                    const std::function<void(const ParticleChunk&)>& use) {
    std::vector<ParticleChunk> chunks(2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
    tbb::concurrent_bounded_queue<ParticleChunk*> free;
    for (auto& chunk : chunks) free.push(&chunk);
    Status status = success();
    std::uint64_t next = begin;
    const auto read = [&](tbb::flow_control& control) -> ParticleChunk* {
        if (next < end && status.ok() && progress.cancelled()) status = cancelledError();
        if (next >= end || !status.ok()) {
            control.stop();
            return nullptr;
        }
        ParticleChunk* chunk = nullptr;
        free.pop(chunk);
        const auto count = static_cast<std::size_t>(std::min(rowsOfChunk, end - next));
        status = source.read(step, next, count, wanted, *chunk);
        next += count;
        if (status.ok()) {
            MOTE_CHECK(chunk->size == count);
            return chunk;
        }
        control.stop();
        return nullptr;
    };
    const auto work = [&](ParticleChunk* chunk) {
        use(*chunk);
        free.push(chunk);
    };
    tbb::parallel_pipeline(chunks.size(),
                           tbb::make_filter<void, ParticleChunk*>(tbb::filter_mode::serial_in_order, read) &
                               tbb::make_filter<ParticleChunk*, void>(tbb::filter_mode::parallel, work));
    return status;
}

}  // namespace mote::prep
