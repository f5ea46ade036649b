// SPDX-License-Identifier: GPL-3.0-or-later
//
// HybridCache: the steps of hybrid volumes that were drawn last, loaded whole, and the next ones while a
// series is played; loaded on threads of its own that give way to those that draw. Each is a block of the
// budget, so that volumes and particles make room for each other. Owned by DatasetService; step() and
// volume() are for the one thread that renders.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "protocol/scene/error.h"
#include "server/data/played_series.h"
#include "server/render/plan/grid_field.h"
#include "storage/blocks/block_budget.h"
#include "storage/catalogue.h"

namespace mote::server {

class HybridCache final : private storage::BudgetedBlocks {
  public:
    static constexpr std::size_t mostSteps = 32;  ///< kept and under way

    using Step = std::shared_ptr<const render::GridField>;

    /// `arrived` is called on the cache's threads, and must be quick, when a step is there or never will be.
    /// At least one thread.
    HybridCache(std::shared_ptr<storage::BlockBudget> budget, unsigned threads,
                std::function<void()> arrived);
    /// Gives up what is under way.
    ~HybridCache();
    HybridCache(const HybridCache&) = delete;
    HybridCache& operator=(const HybridCache&) = delete;

    /// Null where it is not in memory: it is brought in, before all that is only expected, and of a dataset
    /// only the latest. At once comes what is not worth waiting for, a volume alone, and what there was no
    /// room for, or not until it was asked for again. The next steps of a series that is played follow.
    /// Errors: as render::loadHybrid and hybridParts; invalidArgument (a dataset of another kind),
    /// resourceExhausted.
    Result<Step> step(const storage::Catalogue::Entry& entry, std::uint32_t index,
                      HybridRepresentation representation);
    /// Whether the dataset's steps are asked for in an order.
    bool played(const storage::Catalogue::Entry& entry);
    /// A step's coarse grid alone, at once, for as long as the rest is on its way.
    Result<Step> volume(const storage::Catalogue::Entry& entry, std::uint32_t index);

    std::size_t loadedSteps() const;
    std::size_t stepsUnderWay() const;  ///< in line, or being loaded

  private:
    struct Place {
        std::shared_ptr<const proto::Manifest> manifest;  ///< tells a dataset from a later one of its name
        std::filesystem::path directory;
        std::uint32_t index = 0;
        HybridRepresentation parts = HybridRepresentation::volume;
        bool operator==(const Place&) const = default;
    };
    enum class State {
        empty,
        waiting,  ///< in line
        loading,
        loaded,
        late,   ///< was asked for, but there was no room, or it had to go before it was asked for again
        failed  ///< was asked for
    };
    struct Slot {
        Place place;
        State state = State::empty;
        bool wanted = false;  ///< a picture asked for it and has not had it
        Step step;
        std::uint64_t bytes = 0;
        std::optional<Error> error;
        std::atomic<Turn> used{0};
    };

    // Of the budget.
    std::size_t blockCount() const override { return mostSteps; }
    Turn usedIn(std::size_t slot) const override { return slots_[slot].used.load(std::memory_order_relaxed); }
    std::uint64_t blockSize(std::size_t slot) const override { return slots_[slot].bytes; }
    std::uint64_t giveUp(std::size_t slot, Turn used) const override;

    Result<Step> load(const Place& place, Turn turn) const;
    Result<Step> loadAtOnce(const Place& place);
    void run();
    void finish(const Place& place, Result<Step> loaded);
    // Under the mutex.
    Slot* find(const Place& place) const;
    std::size_t count(State state) const;
    Slot& slotFor(const Place& place);
    void clear(Slot& slot) const;
    Step keep(const Place& place, Step step);
    void want(const Place& place);
    void leaveOut(const std::shared_ptr<const proto::Manifest>& manifest);
    void expectNext(const Place& place, bool there);

    const std::shared_ptr<storage::BlockBudget> budget_;
    const std::function<void()> arrived_;
    std::atomic<bool> stopping_{false};

    mutable std::mutex mutex_;  // never held while the budget is asked for room
    std::condition_variable wake_;
    // Under the mutex.
    mutable std::array<Slot, mostSteps> slots_;
    std::deque<Slot*> line_;  // that wait: what is wanted, the latest first; then what is expected
    PlayedSeries<HybridRepresentation> series_;

    std::vector<std::thread> threads_;
};

}  // namespace mote::server
