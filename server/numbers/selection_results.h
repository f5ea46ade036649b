// SPDX-License-Identifier: GPL-3.0-or-later
//
// SelectionResults: which points the selections of late queries hold, and these as a step of their own, so
// that the pieces of one answer, and the next question about the same particles, need not find them again.
// Within a bound of the queries' memory. Any number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/selection.h"
#include "server/numbers/query_memory.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/run_steps.h"
#include "storage/particles/selected_step.h"

namespace mote::server {

class SelectionResults {
  public:
    using Run = std::shared_ptr<const storage::RunSteps>;
    using Cancelled = std::function<bool()>;
    using Mask = std::shared_ptr<const storage::PointMask>;
    using Ids = std::shared_ptr<const std::vector<std::uint64_t>>;

    using Chosen = std::shared_ptr<const storage::SelectedStep>;

    explicit SelectionResults(std::shared_ptr<QueryMemory> memory) : memory_(std::move(memory)) {}

    /// The points of a step that it holds; null: all of them. Errors: as storage::selectPoints;
    /// resourceExhausted.
    Result<Mask> points(const Run& run, std::uint32_t step, const Selection& selection,
                        const Cancelled& cancelled);
    /// The same points as a step; null: all of them. Errors: as points(). Throws storage::StorageError.
    Result<Chosen> chosen(const Run& run, std::uint32_t step, const Selection& selection,
                          const Cancelled& cancelled);
    /// The ids that it holds, ascending, each once: those that it names if it names nothing else, else
    /// those of its points in the step in which it was made, and if it says none, in `step`.
    Result<Ids> ids(const Run& run, std::uint32_t step, const Selection& selection,
                    const Cancelled& cancelled);

  private:
    static constexpr std::size_t kept = 64;
    static constexpr std::uint64_t keptShare = 4;  // of the queries' memory

    struct Entry {
        std::weak_ptr<const storage::RunSteps> run;
        std::uint32_t step;
        Selection selection;
        Mask points;  // or
        Ids ids;
        QueryMemory::Hold memory;
        Chosen chosen = {};  // or
    };
    template <class Member>
    Member find(Member Entry::*member, const Run& run, std::uint32_t step, const Selection& selection);
    void keep(Entry entry, std::uint64_t bytes);

    const std::shared_ptr<QueryMemory> memory_;
    std::mutex mutex_;
    std::list<Entry> entries_;  // under the mutex; the latest first
    std::uint64_t bytes_ = 0;   // of theirs
};

}  // namespace mote::server
