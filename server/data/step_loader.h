// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepLoader: brings into memory what pictures will need of mapped steps, on threads of its own that give way
// to those that draw. Of each step the latest need counts; what is in use is served before what is only
// expected, and of equals the latest. It keeps no step alive. One owner; any thread may say what it wants.
#pragma once

#include <condition_variable>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "storage/blocks/block_budget.h"
#include "storage/particles/mapped_step.h"
#include "storage/particles/step_need.h"

namespace mote::storage {

class StepLoader {
  public:
    enum class Urgency { inUse, expected };

    /// `arrived` is called on the loader's threads, and must be quick, when nothing more will come of a need:
    /// it is served, the budget has no room for its rest, or something failed (ParticleStep::check). At least
    /// one thread.
    StepLoader(std::shared_ptr<BlockBudget> budget, unsigned threads, std::function<void()> arrived);
    /// Waits for the blocks under way, not for the rest.
    ~StepLoader();
    StepLoader(const StepLoader&) = delete;
    StepLoader& operator=(const StepLoader&) = delete;

    /// Takes the place of what was wanted of that step before; an empty need: nothing more. In the budget's
    /// present turn: what was used in it or later is not given up for it. False where the same need was tried
    /// last and found beyond the budget: nothing will come.
    bool want(const std::shared_ptr<const MappedStep>& step, const StepNeed& need, Urgency urgency);
    /// Needs that are not yet served.
    std::size_t waiting() const;

  private:
    struct Task {
        std::weak_ptr<const MappedStep> step;
        const MappedStep* key;
        std::vector<MappedStep::Ahead> ahead;
        StepNeed need;
        Urgency urgency;
        BlockBudget::Turn turn;
        std::size_t at = 0;     ///< of ahead
        std::size_t block = 0;  ///< of it, the next to take
        unsigned busy = 0;      ///< threads that are on it
        bool beyond = false;    ///< there was no room for all of it
    };
    using Tasks = std::list<std::shared_ptr<Task>>;
    /// One block to bring in, or one thing that follows.
    struct Piece {
        std::shared_ptr<Task> task;  ///< null: there is nothing to do
        std::shared_ptr<const MappedStep> step;
        MappedStep::Ahead ahead;  ///< of one block
    };

    void run();
    Piece next();
    enum class Served { yes, noRoom, failed };
    Served serve(const Piece& piece) const;
    /// Whether it was the last piece of its task.
    bool finished(const Piece& piece, Served served);
    void forget(const MappedStep* step);

    const std::shared_ptr<BlockBudget> budget_;
    const std::function<void()> arrived_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    // Under the mutex.
    Tasks tasks_;   // the most urgent first
    Tasks beyond_;  // ended for want of room; the latest of each step
    bool stopping_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace mote::storage
