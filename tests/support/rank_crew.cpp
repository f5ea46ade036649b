// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/rank_crew.h"

#include <string>

namespace mote::test {
namespace {

Error unknown() {
    return {ErrorCode::unsupported, "", "no step of the scene"};
}

template <class Steps, class Step>
Result<render::RankSteps::Name> nameAmong(const Steps& steps, const Step& step) {
    for (std::size_t i = 0; i < steps.size(); ++i)
        if (steps[i].get() == &step) return render::RankSteps::Name{std::to_string(i), "digest"};
    return unknown();
}

}  // namespace

Result<render::RankSteps::Name> SceneSteps::nameOf(const storage::ParticleStep& step) {
    if (onName) onName();
    return nameAmong(steps_, step);
}

Result<std::shared_ptr<const storage::ParticleStep>> SceneSteps::open(const Name& name) {
    if (!broken) return steps_.at(std::stoul(name.file));
    return Error{ErrorCode::notFound, "/data/beam.mote/step-000000.h5", "is not there"};
}

Result<render::RankSteps::Name> SceneSteps::nameOf(const render::GridField& step) {
    return nameAmong(hybrids_, step);
}

Result<std::shared_ptr<const render::GridField>> SceneSteps::openGrid(const Name& name) {
    return hybrids_.at(std::stoul(name.file));
}

void SceneSteps::beginPicture() {
    if (onBegin) onBegin();
}

RankCrew::RankCrew(int size, const render::Scene& scene)
    : ranks_(size), steps_(static_cast<std::size_t>(size), SceneSteps(scene)) {
    for (int rank = 1; rank < size; ++rank) {
        threads_.emplace_back([this, rank] { render::serveRanks(ranks_[rank], steps(rank)); });
    }
    device_ = std::make_unique<render::RankedDevice>(ranks_[0], steps(0));
}

RankCrew::~RankCrew() {
    render::dismissRanks(ranks_[0]);
    for (auto& thread : threads_) thread.join();
}

}  // namespace mote::test
