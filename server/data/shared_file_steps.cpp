// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/data_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <list>
#include <string>
#include <utility>

#include "protocol/base/most_recent.h"
#include "protocol/base/mote_check.h"
#include "protocol/scene/selection.h"
#include "server/data/step_cache.h"
#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/blocks/block_budget.h"
#include "storage/manifest.h"
#include "storage/numbers/dataset_steps.h"
#include "storage/numbers/select_points.h"
#include "storage/particles/mapped_step.h"
#include "storage/particles/selected_step.h"

namespace mote::server {
namespace {

Error replaced(const std::filesystem::path& file) {
    return {ErrorCode::corrupt, file.string(),
            "is not the file that the first rank draws: was the dataset replaced?"};
}

class SharedFileSteps final : public render::RankSteps {
  public:
    SharedFileSteps(storage::Roots roots, std::uint64_t memory);

    Result<Name> nameOf(const storage::ParticleStep& step) override;
    Result<std::shared_ptr<const storage::ParticleStep>> open(const Name& name) override;
    Result<Name> nameOf(const render::GridField& field) override;
    Result<std::shared_ptr<const render::GridField>> openGrid(const Name& name) override;
    std::shared_ptr<storage::BlockBudget> budget() const override { return budget_; }
    void beginPicture() override { budget_->beginGeneration(); }

  private:
    static constexpr std::size_t mostOpen = 16;

    struct OpenStep {
        Name name;
        std::shared_ptr<const storage::ParticleStep> step;
    };
    struct OpenGrid {
        Name name;
        std::shared_ptr<const render::GridField> step;
    };
    Result<Name> nameOf(const storage::StepOrigin& origin) const;
    Result<std::shared_ptr<const storage::ParticleStep>> openFile(const Name& name) const;
    static Result<std::shared_ptr<const storage::ParticleStep>> openChosen(
        const storage::PathBeneath& directory, const proto::Manifest& manifest, std::uint32_t step,
        const std::string& selection);
    Result<std::shared_ptr<const render::GridField>> loadFile(const Name& name);
    Status makeRoom(std::uint64_t bytes);

    const storage::Roots roots_;
    const std::shared_ptr<storage::BlockBudget> budget_;
    std::list<OpenStep> open_;   // the latest first
    std::list<OpenGrid> grids_;  // likewise
};

SharedFileSteps::SharedFileSteps(storage::Roots roots, std::uint64_t memory)
    : roots_(std::move(roots)), budget_(std::make_shared<storage::BlockBudget>(memory)) {}

Result<SharedFileSteps::Name> SharedFileSteps::nameOf(const storage::ParticleStep& step) {
    if (const auto* const chosen = dynamic_cast<const storage::SelectedStep*>(&step);
        chosen != nullptr && chosen->origin) {
        MOTE_ASSIGN_OR_RETURN(auto name, nameOf(chosen->origin->step));
        name.selection = chosen->origin->selection;
        return name;
    }
    const auto* const mapped = dynamic_cast<const storage::MappedStep*>(&step);
    if (mapped == nullptr)
        return Error{ErrorCode::unsupported, "", "a step that lies in no file is not shared"};
    return nameOf(mapped->origin());
}

Result<SharedFileSteps::Name> SharedFileSteps::nameOf(const render::GridField& step) {
    return nameOf(step.origin);
}

Result<SharedFileSteps::Name> SharedFileSteps::nameOf(const storage::StepOrigin& origin) const {
    auto file = roots_.nameOf(origin.file);
    if (file) return Name{*std::move(file), origin.digest};
    return Error{ErrorCode::unsupported, origin.file.string(),
                 "other ranks cannot open it: it lies beneath no root"};
}

Result<std::shared_ptr<const storage::ParticleStep>> SharedFileSteps::open(const Name& name) {
    const auto* const known = mostRecent(open_, [&](const OpenStep& one) { return one.name == name; });
    if (known != nullptr && intact(*known->step)) return known->step;
    if (known != nullptr) open_.pop_front();
    auto opened = openFile(name);
    if (opened.ok()) keepMostRecent(open_, mostOpen, OpenStep{name, *opened});
    return opened;
}

Result<std::shared_ptr<const storage::ParticleStep>> SharedFileSteps::openFile(const Name& name) const {
    const std::filesystem::path file = name.file;
    MOTE_ASSIGN_OR_RETURN(const auto directory, roots_.beneath(file.parent_path().string()));
    MOTE_ASSIGN_OR_RETURN(const auto manifest, storage::readManifest(directory));
    const auto* const entry = storage::findFile(manifest, file.filename().string());
    const auto& steps = manifest.particles().steps();
    const auto at = std::find_if(steps.begin(), steps.end(),
                                 [&](const auto& step) { return step.file() == file.filename().string(); });
    if (entry == nullptr || at == steps.end() || entry->xxh3_128() != name.digest) return replaced(file);
    const auto index = static_cast<std::uint32_t>(at - steps.begin());
    if (!name.selection.empty()) return openChosen(directory, manifest, index, name.selection);
    return storage::ParticleStep::open(directory, manifest, index, budget_);
}

/// Its points are not counted among the memory of steps: they are those of the latest selections.
Result<std::shared_ptr<const storage::ParticleStep>> SharedFileSteps::openChosen(
    const storage::PathBeneath& directory, const proto::Manifest& manifest, std::uint32_t step,
    const std::string& selection) {
    proto::Selection message;
    MOTE_CHECK(message.ParseFromString(selection));
    MOTE_ASSIGN_OR_RETURN(const auto parsed, parseSelection(message));
    const storage::DatasetSteps run(directory, std::make_shared<const proto::Manifest>(manifest));
    MOTE_ASSIGN_OR_RETURN(const auto mask, storage::selectPoints(parsed, run, step, {}));
    MOTE_ASSIGN_OR_RETURN(const auto numbers, run.step(step));
    MOTE_ASSIGN_OR_RETURN(
        const auto chosen,
        storage::SelectedStep::make(*numbers.points, mask, manifest.particles().leaf_capacity(), {}));
    numbers.points->check();
    return std::shared_ptr<const storage::ParticleStep>(chosen);
}

Result<std::shared_ptr<const render::GridField>> SharedFileSteps::openGrid(const Name& name) {
    const auto* const known = mostRecent(grids_, [&](const OpenGrid& one) { return one.name == name; });
    if (known != nullptr) return known->step;
    auto loaded = loadFile(name);
    if (!loaded.ok()) return loaded;
    MOTE_RETURN_IF_ERROR(makeRoom((*loaded)->bytes()));
    grids_.push_front({name, *loaded});
    return loaded;
}

Result<std::shared_ptr<const render::GridField>> SharedFileSteps::loadFile(const Name& name) {
    const std::filesystem::path file = name.file;
    MOTE_ASSIGN_OR_RETURN(const auto directory, roots_.beneath(file.parent_path().string()));
    MOTE_ASSIGN_OR_RETURN(const auto manifest, storage::readManifest(directory));
    const auto& steps = manifest.hybrid().steps();
    const auto at = std::find_if(steps.begin(), steps.end(),
                                 [&](const auto& step) { return step.file() == file.filename().string(); });
    if (at == steps.end() || render::hybridDigest(manifest) != name.digest) return replaced(file);
    const auto index = static_cast<std::uint32_t>(at - steps.begin());
    const std::uint64_t expected = render::hybridBytes(manifest.hybrid(), index, name.parts);
    MOTE_RETURN_IF_ERROR(makeRoom(expected));
    auto loaded = render::loadHybrid(directory, manifest, index, name.parts);
    budget_->giveBack(expected);
    return loaded;
}

Status SharedFileSteps::makeRoom(std::uint64_t bytes) {
    while (!budget_->take(bytes, budget_->generation())) {
        if (grids_.empty()) {
            return Error{
                ErrorCode::resourceExhausted, "dataset",
                fmt::format("its step takes {} MiB, more than the server has for data", bytes >> 20)};
        }
        budget_->giveBack(grids_.back().step->bytes());
        grids_.pop_back();
    }
    return success();
}

}  // namespace

std::unique_ptr<render::RankSteps> sharedFileSteps(storage::Roots roots, std::uint64_t memory) {
    return std::make_unique<SharedFileSteps>(std::move(roots), memory);
}

}  // namespace mote::server
