// SPDX-License-Identifier: GPL-3.0-or-later
//
// RankCrew: the device of several ranks that are threads of the test, for one scene whose data all of them
// have in memory. The ranks serve while it lives; its device belongs to the thread that made it.
#pragma once

#include <atomic>
#include <barrier>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "server/render/layers/scene.h"
#include "server/render/ranks/rank_steps.h"
#include "server/render/ranks/ranked_device.h"
#include "server/render/ranks/ranks.h"

namespace mote::test {

/// Ranks that are threads of the test, without MPI. Whoever makes the group owns it; each rank
/// belongs to one thread at a time.
class ThreadRanks {
  public:
    explicit ThreadRanks(int size);
    ~ThreadRanks();
    ThreadRanks(const ThreadRanks&) = delete;
    ThreadRanks& operator=(const ThreadRanks&) = delete;

    int size() const { return static_cast<int>(ranks_.size()); }
    render::Ranks& operator[](int rank) { return *ranks_[static_cast<std::size_t>(rank)]; }

  private:
    class Rank;

    std::barrier<> meeting_;
    std::vector<std::vector<render::Bytes>> messages_;  // by sender and receiver
    std::atomic<std::uint64_t> stopped_{0};
    std::vector<std::unique_ptr<render::Ranks>> ranks_;
};

/// The steps of one scene.
class SceneSteps final : public render::RankSteps {
  public:
    explicit SceneSteps(const render::Scene& scene) : layers_(scene.layers) {}

    Result<Name> nameOf(const storage::ParticleStep& step) override;
    Result<std::shared_ptr<const storage::ParticleStep>> open(const Name& name) override;
    Result<Name> nameOf(const render::GridField& step) override;
    Result<std::shared_ptr<const render::GridField>> openGrid(const Name& name) override;
    std::shared_ptr<storage::BlockBudget> budget() const override { return memory; }
    void beginPicture() override;

    std::shared_ptr<storage::BlockBudget> memory;  ///< of this rank, never short
    std::function<void()>
        onName;  ///< called before a step of particles is named, so before an order goes out
    std::function<void()> onBegin;  ///< called on other ranks than the first when a picture begins
    bool broken = false;            ///< no step of particles can be opened

  private:
    std::vector<render::LayerData> layers_;
};

class RankCrew {
  public:
    RankCrew(int size, const render::Scene& scene);
    ~RankCrew();
    RankCrew(const RankCrew&) = delete;
    RankCrew& operator=(const RankCrew&) = delete;

    SceneSteps& steps(int rank) { return steps_[static_cast<std::size_t>(rank)]; }
    render::Device& device() { return *device_; }

  private:
    ThreadRanks ranks_;
    std::vector<SceneSteps> steps_;
    std::vector<std::thread> threads_;
    std::unique_ptr<render::Device> device_;
};

}  // namespace mote::test
