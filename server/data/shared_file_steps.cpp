// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/shared_file_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/manifest.h"
#include "storage/particles/mapped_step.h"
#include "storage/storage_error.h"

namespace mote::render {
namespace {

bool intact(const storage::ParticleStep& step) {
    try {
        step.check();
        return true;
    } catch (const storage::StorageError&) {
        return false;
    }
}

Error replaced(const std::filesystem::path& file) {
    return {ErrorCode::corrupt, file.string(),
            "is not the file that the first rank draws: was the dataset replaced?"};
}

}  // namespace

SharedFileSteps::SharedFileSteps(storage::Roots roots, std::uint64_t memory)
    : roots_(std::move(roots)), budget_(std::make_shared<storage::BlockBudget>(memory)) {}

Result<RankSteps::Name> SharedFileSteps::nameOf(const storage::ParticleStep& step) {
    const auto* const mapped = dynamic_cast<const storage::MappedStep*>(&step);
    if (mapped == nullptr)
        return Error{ErrorCode::unsupported, "", "a step that lies in no file is not shared"};
    return nameOf(mapped->origin());
}

Result<RankSteps::Name> SharedFileSteps::nameOf(const GridField& step) {
    return nameOf(step.origin);
}

Result<RankSteps::Name> SharedFileSteps::nameOf(const storage::StepOrigin& origin) const {
    auto file = roots_.nameOf(origin.file);
    if (file) return Name{*std::move(file), origin.digest};
    return Error{ErrorCode::unsupported, origin.file.string(),
                 "other ranks cannot open it: it lies beneath no root"};
}

Result<std::shared_ptr<const storage::ParticleStep>> SharedFileSteps::open(const Name& name) {
    const auto found =
        std::find_if(open_.begin(), open_.end(), [&](const OpenStep& one) { return one.name == name; });
    if (found != open_.end() && intact(*found->step)) {
        open_.splice(open_.begin(), open_, found);
        return found->step;
    }
    if (found != open_.end()) open_.erase(found);
    auto opened = openFile(name);
    if (!opened.ok()) return opened;
    open_.push_front({name, *opened});
    if (open_.size() > mostOpen) open_.pop_back();
    return opened;
}

Result<std::shared_ptr<const storage::ParticleStep>> SharedFileSteps::openFile(const Name& name) const {
    const auto file = roots_.resolveExisting(name.file);
    if (!file.ok()) return file.error();
    const auto directory = file->parent_path();
    const auto manifest = storage::readManifest(directory);
    if (!manifest.ok()) return manifest.error();
    const auto* const entry = storage::findFile(*manifest, file->filename().string());
    const auto& steps = manifest->particles().steps();
    const auto at = std::find_if(steps.begin(), steps.end(),
                                 [&](const auto& step) { return step.file() == file->filename().string(); });
    if (entry == nullptr || at == steps.end() || entry->xxh3_128() != name.digest) return replaced(*file);
    return storage::ParticleStep::open(directory, *manifest, static_cast<std::uint32_t>(at - steps.begin()),
                                       budget_);
}

Result<std::shared_ptr<const GridField>> SharedFileSteps::openGrid(const Name& name) {
    const auto found =
        std::find_if(grids_.begin(), grids_.end(), [&](const OpenGrid& one) { return one.name == name; });
    if (found != grids_.end()) {
        grids_.splice(grids_.begin(), grids_, found);
        return found->step;
    }
    auto loaded = loadFile(name);
    if (!loaded.ok()) return loaded;
    MOTE_RETURN_IF_ERROR(makeRoom((*loaded)->bytes()));
    grids_.push_front({name, *loaded});
    return loaded;
}

Result<std::shared_ptr<const GridField>> SharedFileSteps::loadFile(const Name& name) {
    const auto file = roots_.resolveExisting(name.file);
    if (!file.ok()) return file.error();
    const auto manifest = storage::readManifest(file->parent_path());
    if (!manifest.ok()) return manifest.error();
    const auto& steps = manifest->hybrid().steps();
    const auto at = std::find_if(steps.begin(), steps.end(),
                                 [&](const auto& step) { return step.file() == file->filename().string(); });
    if (at == steps.end() || hybridDigest(*manifest) != name.digest) return replaced(*file);
    const auto index = static_cast<std::uint32_t>(at - steps.begin());
    const std::uint64_t expected = hybridBytes(manifest->hybrid(), index, name.parts);
    MOTE_RETURN_IF_ERROR(makeRoom(expected));
    auto loaded = loadHybrid(file->parent_path(), *manifest, index, name.parts);
    budget_->giveBack(expected);
    return loaded;
}

Status SharedFileSteps::makeRoom(std::uint64_t bytes) {
    while (!budget_->take(bytes, budget_->turn())) {
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

}  // namespace mote::render
