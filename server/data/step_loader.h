// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepLoader: brings into memory what pictures will need of mapped steps, on threads of its own that give way
// to those that draw. Of each step the latest need counts; what is in use is served before what is only
// expected, and of equals the latest. It keeps no step alive. One owner; any thread may say what it wants.
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "server/data/loading_threads.h"
#include "storage/blocks/block_budget.h"
#include "storage/particles/mapped_step.h"
#include "storage/particles/particle_step.h"

namespace mote::server {

class StepLoader {
  public:
    enum class Urgency { inUse, expected };

    /// `arrived` is called on the loader's threads, and must be quick, when nothing more will come of a need:
    /// it is served, the budget has no room for its rest, or something failed (ParticleStep::check). At least
    /// one thread.
    StepLoader(std::shared_ptr<storage::BlockBudget> budget, unsigned threads, std::function<void()> arrived);

    /// Takes the place of what was wanted of that step before; an empty need: nothing more. In the budget's
    /// present generation: what was used in it or later is not given up for it. False where the same need was
    /// tried last and found beyond the budget: nothing will come.
    bool want(const std::shared_ptr<const storage::MappedStep>& step, const storage::StepNeed& need,
              Urgency urgency);
    /// Needs that are not yet served.
    std::size_t waiting() const;

  private:
    struct Task {
        std::weak_ptr<const storage::MappedStep> step;
        const storage::MappedStep* key;
        std::vector<storage::MappedStep::Ahead> ahead;
        storage::StepNeed need;
        Urgency urgency;
        storage::BlockBudget::Generation generation;
        std::size_t at = 0;     ///< index into `ahead`
        std::size_t block = 0;  ///< the next one of that to take
        unsigned busy = 0;      ///< threads that are on it
        bool beyond = false;    ///< there was no room for all of it
    };
    using Tasks = std::list<std::shared_ptr<Task>>;
    /// One block to bring in, or one thing that follows.
    struct Piece {
        std::shared_ptr<Task> task;  ///< null: there is nothing to do
        std::shared_ptr<const storage::MappedStep> step;
        storage::MappedStep::Ahead ahead;  ///< of one block
    };

    bool loadOne();
    Piece next();
    enum class Served { yes, noRoom, failed };
    Served serve(const Piece& piece) const;
    /// Whether it was the last piece of its task.
    bool finished(const Piece& piece, Served served);
    void forget(const storage::MappedStep* step);

    const std::shared_ptr<storage::BlockBudget> budget_;
    const std::function<void()> arrived_;
    mutable std::mutex mutex_;
    // Under the mutex.
    Tasks tasks_;   // the most urgent first
    Tasks beyond_;  // ended for want of room; the latest of each step

    LoadingThreads threads_;
};

}  // namespace mote::server
