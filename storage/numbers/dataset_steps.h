// SPDX-License-Identifier: GPL-3.0-or-later
//
// DatasetSteps: the steps of a published particle plot, opened when they are asked for. It keeps those that
// were asked for last; any number of threads.
#pragma once

#include <list>
#include <memory>
#include <mutex>

#include "storage/files/path_beneath.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

class BlockBudget;

class DatasetSteps final : public RunSteps {
  public:
    /// `manifest` is of a particle plot, checked (storage/manifest.h), `directory` the dataset. With a
    /// budget, blocks come and go as those of ParticleStep do.
    DatasetSteps(PathBeneath directory, std::shared_ptr<const proto::Manifest> manifest,
                 std::shared_ptr<BlockBudget> budget = nullptr);

    const proto::ParticlesManifest& manifest() const override { return manifest_->particles(); }
    /// Means are the step's statistics, or where the dataset was made without, those of its columns.
    Result<StepNumbers> step(std::uint32_t index) const override;

  private:
    static constexpr std::size_t kept = 4;

    struct Opened {
        std::uint32_t index;
        StepNumbers numbers;
    };
    Result<StepNumbers> open(std::uint32_t index) const;
    std::optional<StepNumbers> find(std::uint32_t index) const;

    const PathBeneath directory_;
    const std::shared_ptr<const proto::Manifest> manifest_;
    const std::shared_ptr<BlockBudget> budget_;  ///< may be null
    mutable std::mutex mutex_;
    mutable std::list<Opened> opened_;  // under the mutex; the latest first
};

}  // namespace mote::storage
