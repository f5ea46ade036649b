// SPDX-License-Identifier: GPL-3.0-or-later
//
// GatedSource: datasets of a folder, for tests of pictures that wait for their data. The test's thread makes
// it and draws; others read.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/data/residency.h"
#include "server/data/step_source.h"
#include "storage/manifest.h"

namespace mote::server {

/// Datasets of a folder in a Residency, whose threads wait at a gate and are noted.
class GatedSource final : public StepSource {
  public:
    explicit GatedSource(std::filesystem::path folder) : folder_(std::move(folder)) {}
    ~GatedSource() override { open(); }

    Result<storage::Catalogue::Entry> dataset(const std::string& name) override {
        if (!entries_.contains(name)) {
            const auto manifest = storage::readManifest(folder_ / (name + ".mote"));
            if (!manifest.ok()) return Error{ErrorCode::notFound, "dataset", name};
            entries_[name] = {name, folder_ / (name + ".mote"),
                              std::make_shared<const proto::Manifest>(*manifest)};
        }
        return entries_[name];
    }
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& name,
                                                              std::uint32_t) override {
        return Error{ErrorCode::notFound, "dataset", name};
    }
    Result<Resident> resident(const AnyLoadable& what) override {
        AnyLoadable gated = what;
        gated.load = [this, load = what.load](std::uint32_t step, const AnyLoadable::Cancelled& cancelled) {
            std::unique_lock lock(mutex_);
            threads_.push_back(std::this_thread::get_id());
            changed_.wait(lock, [this] { return open_; });
            lock.unlock();
            return load(step, cancelled);
        };
        return residency_.get(gated);
    }
    void beginPicture() override { budget_->beginGeneration(); }

    void open() {
        const std::lock_guard lock(mutex_);
        open_ = true;
        changed_.notify_all();
    }
    void awaitRest() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return residency_.underWay() == 0; });
    }
    std::vector<std::thread::id> threads() {
        const std::lock_guard lock(mutex_);
        return threads_;
    }
    std::uint64_t counted() const { return budget_->resident(); }

  private:
    const std::filesystem::path folder_;
    std::map<std::string, storage::Catalogue::Entry> entries_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool open_ = false;
    std::vector<std::thread::id> threads_;  // that loaded
    const std::shared_ptr<storage::BlockBudget> budget_ =
        std::make_shared<storage::BlockBudget>(std::uint64_t{1} << 30);
    Residency residency_{budget_, 2, [this] {
                             const std::lock_guard lock(mutex_);
                             changed_.notify_all();
                         }};
};

}  // namespace mote::server
