// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepCache: the steps that are open, what of them is in memory (storage/blocks/block_budget.h), and the
// next ones while a series is played, opened and loaded before they are asked for. Owned by DatasetService;
// step() and want() are for the one thread that renders.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "protocol/base/error.h"
#include "server/data/loading_threads.h"
#include "server/data/played_series.h"
#include "storage/blocks/block_budget.h"
#include "storage/catalogue.h"
#include "storage/particles/mapped_step.h"

namespace mote::server {

/// StepLoader: brings into memory what pictures will need of mapped steps, on threads of its own that give
/// way to those that draw. Of each step the latest need counts; what is in use is served before what is only
/// expected, and of equals the latest. It keeps no step alive. One owner; any thread may say what it wants.
class StepLoader {
  public:
    enum class Urgency { inUse, expected };

    /// `arrived` is called on the loader's threads, and must be quick, when nothing more will come of a need:
    /// it is served, the budget has no room for its rest, or something failed (ParticleStep::check). At least
    /// one thread.
    StepLoader(std::shared_ptr<storage::BlockBudget> budget, unsigned threads, std::function<void()> arrived);

    /// Takes the place of what was wanted of that step before; an empty need: nothing more. In the budget's
    /// present generation: what was used in it or later is not given up for it. False if the same need was
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

/// Whether it may be used any more: its file is what it was.
bool intact(const storage::ParticleStep& step);

class StepCache {
  public:
    static constexpr std::size_t mostSteps = 64;  ///< open at once; each takes a file descriptor

    using Step = std::shared_ptr<const storage::MappedStep>;

    /// `arrived` as StepLoader's.
    StepCache(std::shared_ptr<storage::BlockBudget> budget, unsigned threads, std::function<void()> arrived);

    /// Opens it if it is not open, or is damaged. Errors: as MappedStep::open.
    Result<Step> step(const storage::Catalogue::Entry& entry, std::uint32_t index);
    /// As StepSource::want.
    bool want(const storage::ParticleStep& step, const storage::StepNeed& need);
    std::size_t openSteps() const;
    /// Indices of the dataset's steps of which all is in memory that the latest pictures of it needed,
    /// ascending. Any thread.
    std::vector<std::uint32_t> loaded(const storage::Catalogue::Entry& entry) const;

  private:
    /// A step of a dataset; the manifest tells a dataset from a later one of its name.
    struct Place {
        std::shared_ptr<const proto::Manifest> manifest;
        storage::PathBeneath directory;
        std::uint32_t index = 0;

        /// Whether `later` is the same step, if need be of what a live dataset has become since.
        bool holds(const Place& later) const;
    };
    struct OpenStep {
        Place place;
        Step step;
    };
    struct Need {
        storage::StepNeed need = {};
        std::uint64_t points = 0;  ///< of the step whose need it is
    };
    using Played = PlayedSeries<Need>;

    Result<Step> open(const Place& place);
    Step find(const Place& place);
    Step insert(const Place& place, Step step);
    Played::Series& seriesOf(const Place& place);
    void expectNext(const Place& place);
    bool openNext();
    storage::StepNeed needOf(const Place& place, const storage::MappedStep& step);

    const std::shared_ptr<storage::BlockBudget> budget_;
    StepLoader loader_;

    mutable std::mutex mutex_;
    // Under the mutex.
    std::list<OpenStep> steps_;  // the latest first
    Played series_;
    std::vector<Place> expected_;  // to be opened ahead

    LoadingThreads thread_;  // opens what is expected
};

}  // namespace mote::server
