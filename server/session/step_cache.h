// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepCache: the steps that are open, what of them is in memory (storage/particles/block_budget.h), and the
// next ones while a series is played, opened and loaded before they are asked for. Owned by DatasetService;
// step(), want() and beginPicture() are for the one thread that renders.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "protocol/scene/error.h"
#include "server/session/play_order.h"
#include "storage/catalogue.h"
#include "storage/particles/step_loader.h"

namespace mote::server {

class StepCache {
  public:
    static constexpr std::size_t mostSteps = 64;  ///< open at once; each takes a file descriptor
    static constexpr std::size_t nextSteps = 4;   ///< loaded ahead of a series that is played

    using Step = std::shared_ptr<const storage::MappedStep>;

    /// `bytes` of blocks in memory; `arrived` as StepLoader's.
    StepCache(std::uint64_t bytes, unsigned threads, std::function<void()> arrived);
    ~StepCache();
    StepCache(const StepCache&) = delete;
    StepCache& operator=(const StepCache&) = delete;

    /// Opens it where it is not open, or is damaged. Errors: as MappedStep::open.
    Result<Step> step(const storage::Catalogue::Entry& entry, std::uint32_t index);
    /// As StepSource::want.
    bool want(const storage::ParticleStep& step, const storage::StepNeed& need);
    /// What was used before may leave memory from now on.
    void beginPicture() { budget_->beginTurn(); }

    /// Memory that something else takes of the same bytes, until it is given back. False where there is no
    /// room, also when all blocks go that the present picture does not use.
    bool take(std::uint64_t bytes) { return budget_->take(bytes, budget_->turn()); }
    void giveBack(std::uint64_t bytes) { budget_->giveBack(bytes); }

    std::size_t openSteps() const;
    const storage::BlockBudget& budget() const { return *budget_; }

  private:
    using Manifest = std::shared_ptr<const proto::Manifest>;
    /// A step of a dataset; the manifest tells a dataset from a later one of its name.
    struct Place {
        Manifest manifest;
        std::filesystem::path directory;
        std::uint32_t index;
        bool operator==(const Place&) const = default;
    };
    struct OpenStep {
        Place place;
        Step step;
    };
    /// What the pictures of a dataset's latest step needed, and how its steps are played.
    struct Series {
        Manifest manifest;
        PlayOrder order;
        storage::StepNeed need = {};
        std::uint64_t points = 0;  ///< of the step whose need it is
    };

    Result<Step> open(const Place& place);
    Step find(const Place& place);
    Step insert(const Place& place, Step step);
    Series& seriesOf(const Place& place);
    void expectNext(const Place& place);
    void prefetch();
    storage::StepNeed needOf(const Place& place, const storage::MappedStep& step);

    const std::shared_ptr<storage::BlockBudget> budget_;
    storage::StepLoader loader_;

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    // Under the mutex.
    std::list<OpenStep> steps_;    // the latest first
    std::list<Series> series_;     // the latest first
    std::vector<Place> expected_;  // to be opened ahead
    bool stopping_ = false;

    std::thread thread_;  // opens what is expected
};

}  // namespace mote::server
