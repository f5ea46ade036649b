// SPDX-License-Identifier: GPL-3.0-or-later
//
// DatasetService: the datasets that the server offers. It owns the catalogue and looks at the disk on a
// thread of its own, so that a slow file system delays nobody who does not ask for it; what it last saw can
// be asked for from any thread at once. What the renderer needs of them is kept within a bound of memory.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "server/data/residency.h"
#include "server/data/run_source.h"
#include "server/data/step_cache.h"
#include "server/data/step_source.h"
#include "storage/catalogue.h"
#include "storage/numbers/dataset_steps.h"

namespace mote::server {

/// Whoever waits for an answer, which comes unless the service ends first.
template <class Answer>
struct Asker {
    /// Called on the service's thread; a few times, with pauses, where it throws, as memory may come back.
    std::function<void(Answer)> answered;
    /// Called there in place of the answer where that threw every time. Needs no memory and throws nothing.
    std::function<void()> inVain;
};

class DatasetService final : public StepSource, public RunSource {
  public:
    /// `changed` is called on the service's thread when the datasets are not the same as before.
    /// Data take `memory` bytes; `arrived` is called on other threads when nothing more will come of what
    /// want() or resident() asked for, and must be quick.
    DatasetService(storage::Roots roots, std::function<void()> changed, std::uint64_t memory,
                   std::function<void()> arrived);
    /// Waits for what the thread does.
    ~DatasetService() override;
    DatasetService(const DatasetService&) = delete;
    DatasetService& operator=(const DatasetService&) = delete;

    /// Looks at the disk soon. Requests that come meanwhile are one.
    void rescan();
    /// As rescan(), then answers: what was on the disk when this was called is known then. Errors:
    /// resourceExhausted (there was no memory for that).
    void rescan(Asker<Status> asker);

    /// What the last look at the disk took: whoever looks often should mind it.
    std::chrono::steady_clock::duration lookTime() const { return lookTime_; }

    std::shared_ptr<const proto::Catalogue> catalogue() const;
    bool contains(const std::string& dataset) const;

    /// Errors: notFound, resourceExhausted.
    void describe(std::string dataset, Asker<Result<proto::Description>> asker);

    Result<storage::Catalogue::Entry> dataset(const std::string& name) override;
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& dataset,
                                                              std::uint32_t index) override;
    Result<Resident> resident(const AnyLoadable& what) override { return residency_.get(what); }
    bool played(const storage::Catalogue::Entry& dataset) override { return residency_.played(dataset); }
    bool want(const storage::ParticleStep& step, const storage::StepNeed& need) override;
    void beginPicture() override { budget_->beginGeneration(); }
    /// Those that were asked for last are kept open. Its own budget of blocks is that of pictures.
    Result<std::shared_ptr<const storage::RunSteps>> run(const std::string& dataset) override;
    std::shared_ptr<storage::BlockBudget> budget() const override { return budget_; }

  private:
    /// What a scan found; immutable.
    struct Known {
        proto::Catalogue summary;
        std::map<std::string, storage::Catalogue::Entry> entries;
    };

    struct Work {
        std::function<void()> task;
        std::function<void()> inVain = {};  ///< as an asker's; empty: nobody waits for it
    };

    void run();
    static void perform(const Work& work);
    static bool tryAgainAndAgain(const std::function<void()>& task);
    void look();
    void report();
    void enqueue(Work work);
    std::shared_ptr<const Known> known() const;
    struct OpenRun {
        std::shared_ptr<const proto::Manifest> manifest;  ///< tells a dataset from a later one of its name
        std::shared_ptr<const storage::DatasetSteps> steps;
    };
    Result<proto::Description> describeKnown(const std::string& name);

    // The thread's own.
    storage::Catalogue catalogue_;
    std::set<std::string> reported_;  // what the last look left out
    bool behind_ = false;             // known_ lacks what the catalogue has seen, or nobody was told
    bool looked_ = true;              // the latest look came to its end
    const std::function<void()> changed_;
    std::atomic<std::chrono::steady_clock::duration> lookTime_{std::chrono::steady_clock::duration::zero()};

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    // Under the mutex.
    std::shared_ptr<const Known> known_;
    std::deque<Work> work_;
    bool rescanWaits_ = false;
    bool stopping_ = false;
    std::list<OpenRun> runs_;  // the latest first

    const std::shared_ptr<storage::BlockBudget> budget_;
    StepCache steps_;  // of the rendering thread
    Residency residency_;
    std::thread thread_;
};

}  // namespace mote::server
