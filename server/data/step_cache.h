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

#include "protocol/scene/error.h"
#include "server/data/played_series.h"
#include "server/data/step_loader.h"
#include "storage/catalogue.h"

namespace mote::server {

/// Whether it may be used any more: its file is what it was.
bool intact(const storage::ParticleStep& step);

class StepCache {
  public:
    static constexpr std::size_t mostSteps = 64;  ///< open at once; each takes a file descriptor

    using Step = std::shared_ptr<const storage::MappedStep>;

    /// `arrived` as StepLoader's.
    StepCache(std::shared_ptr<storage::BlockBudget> budget, unsigned threads, std::function<void()> arrived);

    /// Opens it where it is not open, or is damaged. Errors: as MappedStep::open.
    Result<Step> step(const storage::Catalogue::Entry& entry, std::uint32_t index);
    /// As StepSource::want.
    bool want(const storage::ParticleStep& step, const storage::StepNeed& need);
    std::size_t openSteps() const;

  private:
    /// A step of a dataset; the manifest tells a dataset from a later one of its name.
    struct Place {
        std::shared_ptr<const proto::Manifest> manifest;
        std::filesystem::path directory;
        std::uint32_t index = 0;
        bool operator==(const Place&) const = default;
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
