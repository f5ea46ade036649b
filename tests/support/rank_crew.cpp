// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/rank_crew.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace mote::test {

class ThreadRanks::Rank final : public render::Ranks {
  public:
    Rank(ThreadRanks& group, int rank) : group_(group), rank_(rank) {}

    int rank() const override { return rank_; }
    int size() const override { return group_.size(); }

    void broadcast(render::Bytes& bytes) noexcept override {
        bytes = exchange(std::vector<render::Bytes>(static_cast<std::size_t>(size()), bytes)).front();
    }

    std::vector<render::Bytes> exchange(const std::vector<render::Bytes>& outgoing) noexcept override {
        const auto mine = static_cast<std::size_t>(rank_);
        group_.messages_[mine] = outgoing;
        group_.meeting_.arrive_and_wait();
        std::vector<render::Bytes> incoming;
        for (const auto& from : group_.messages_) incoming.push_back(from[mine]);
        group_.meeting_.arrive_and_wait();
        return incoming;
    }

    std::uint64_t greatest(std::uint64_t mine) noexcept override {
        const auto all = share(mine);
        return *std::max_element(all.begin(), all.end());
    }
    std::uint64_t sum(std::uint64_t mine) noexcept override {
        std::uint64_t total = 0;
        for (const auto value : share(mine)) total += value;
        return total;
    }

    void sendStop(std::uint64_t picture) noexcept override { group_.stopped_ = picture; }
    bool stopArrived(std::uint64_t picture) noexcept override { return group_.stopped_ == picture; }

  private:
    std::vector<std::uint64_t> share(std::uint64_t mine) {
        const auto* const first = reinterpret_cast<const std::byte*>(&mine);
        const render::Bytes bytes(first, first + sizeof(mine));
        std::vector<std::uint64_t> all;
        for (const auto& from : exchange(std::vector<render::Bytes>(static_cast<std::size_t>(size()), bytes)))
            std::memcpy(&all.emplace_back(), from.data(), sizeof(mine));
        return all;
    }

    ThreadRanks& group_;
    const int rank_;
};

ThreadRanks::ThreadRanks(int size) : meeting_(size), messages_(static_cast<std::size_t>(size)) {
    for (int rank = 0; rank < size; ++rank) ranks_.push_back(std::make_unique<Rank>(*this, rank));
}

ThreadRanks::~ThreadRanks() = default;

namespace {

Error unknown() {
    return {ErrorCode::unsupported, "", "no step of the scene"};
}

template <class Step>
Result<render::RankSteps::Name> nameAmong(const std::vector<render::LayerData>& layers,
                                          std::shared_ptr<const Step> render::LayerData::*of,
                                          const Step& step) {
    for (std::size_t i = 0; i < layers.size(); ++i)
        if ((layers[i].*of).get() == &step) return render::RankSteps::Name{std::to_string(i), "digest"};
    return unknown();
}

}  // namespace

Result<render::RankSteps::Name> SceneSteps::nameOf(const storage::ParticleStep& step) {
    if (onName) onName();
    return nameAmong(layers_, &render::LayerData::step, step);
}

Result<std::shared_ptr<const storage::ParticleStep>> SceneSteps::open(const Name& name) {
    if (!broken) return layers_.at(std::stoul(name.file)).step;
    return Error{ErrorCode::notFound, "/data/beam.mote/step-000000.h5", "is not there"};
}

Result<render::RankSteps::Name> SceneSteps::nameOf(const render::GridField& step) {
    return nameAmong(layers_, &render::LayerData::hybrid, step);
}

Result<std::shared_ptr<const render::GridField>> SceneSteps::openGrid(const Name& name) {
    return layers_.at(std::stoul(name.file)).hybrid;
}

void SceneSteps::beginPicture() {
    if (onBegin) onBegin();
}

RankCrew::RankCrew(int size, const render::Scene& scene)
    : ranks_(size), steps_(static_cast<std::size_t>(size), SceneSteps(scene)) {
    constexpr std::uint64_t much = std::uint64_t{1} << 30;
    for (SceneSteps& steps : steps_) steps.memory = std::make_shared<storage::BlockBudget>(much);
    for (int rank = 1; rank < size; ++rank) {
        threads_.emplace_back([this, rank] { render::serveRanks(ranks_[rank], steps(rank)); });
    }
    device_ = std::make_unique<render::RankedDevice>(ranks_[0], steps(0));
    device_->countTo(steps(0).memory);
}

RankCrew::~RankCrew() {
    render::dismissRanks(ranks_[0]);
    for (auto& thread : threads_) thread.join();
}

}  // namespace mote::test
