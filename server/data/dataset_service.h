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

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/data/residency.h"
#include "server/data/step_cache.h"
#include "server/data/step_source.h"
#include "storage/catalogue.h"
#include "storage/numbers/dataset_steps.h"

namespace mote::server {

class DatasetService final : public StepSource, public RunSource {
  public:
    /// Called with the answer on the service's thread, unless the service ends first.
    template <class Answer>
    using Answered = std::function<void(Answer)>;

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
    /// As rescan(), then answers: what was on the disk when this was called is known then.
    void rescan(Answered<Status> answered);

    /// What the last look at the disk took: whoever looks often should mind it.
    std::chrono::steady_clock::duration lookTime() const { return lookTime_; }

    std::shared_ptr<const proto::Catalogue> catalogue() const;
    bool contains(const std::string& dataset) const;

    /// Errors: notFound.
    void describe(std::string dataset, Answered<Result<proto::Description>> answered);

    /// Which steps are in memory, as far as the latest pictures needed them. Errors: notFound.
    Result<proto::Loaded> loaded(const std::string& dataset);

    Result<storage::Catalogue::Entry> dataset(const std::string& name) override;
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& dataset,
                                                              std::uint32_t index) override;
    Result<Resident> resident(const AnyLoadable& what) override { return residency_.get(what); }
    bool played(const storage::Catalogue::Entry& dataset) override { return residency_.played(dataset); }
    bool want(const storage::ParticleStep& step, const storage::StepNeed& need) override;
    void beginPicture() override { budget_->beginGeneration(); }
    /// Those that were asked for last are kept open. Its own budget of blocks is that of pictures.
    Result<std::shared_ptr<const storage::RunSteps>> run(const std::string& dataset) override;
    std::shared_ptr<storage::BlockBudget> budget() const { return budget_; }

  private:
    /// What a scan found; immutable.
    struct Known {
        proto::Catalogue summary;
        std::map<std::string, storage::Catalogue::Entry> entries;
    };

    void run();
    void look();
    void report();
    void enqueue(std::function<void()> work);
    std::shared_ptr<const Known> known() const;
    struct OpenRun {
        std::shared_ptr<const proto::Manifest> manifest;  ///< tells a dataset from a later one of its name
        std::shared_ptr<const storage::DatasetSteps> steps;
    };
    Result<proto::Description> describeKnown(const std::string& name);

    // The thread's own.
    storage::Catalogue catalogue_;
    std::set<std::string> reported_;  // what the last look left out
    const std::function<void()> changed_;
    std::atomic<std::chrono::steady_clock::duration> lookTime_{std::chrono::steady_clock::duration::zero()};

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    // Under the mutex.
    std::shared_ptr<const Known> known_;
    std::deque<std::function<void()>> work_;
    bool rescanWaits_ = false;
    bool stopping_ = false;
    std::list<OpenRun> runs_;  // the latest first

    const std::shared_ptr<storage::BlockBudget> budget_;
    StepCache steps_;  // of the rendering thread
    Residency residency_;
    std::thread thread_;
};

}  // namespace mote::server
