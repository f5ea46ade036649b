// SPDX-License-Identifier: GPL-3.0-or-later
//
// SharedFileSteps: the RankSteps of a file system that all ranks see, beneath roots of the same names. Keeps
// the latest steps open. One thread.
#pragma once

#include <cstdint>
#include <list>
#include <string>

#include "server/render/ranks/rank_steps.h"
#include "storage/blocks/block_budget.h"
#include "storage/roots.h"

namespace mote::server {

class SharedFileSteps final : public render::RankSteps {
  public:
    /// `memory`: bytes of the steps that were opened.
    SharedFileSteps(storage::Roots roots, std::uint64_t memory);

    Result<Name> nameOf(const storage::ParticleStep& step) override;
    Result<std::shared_ptr<const storage::ParticleStep>> open(const Name& name) override;
    Result<Name> nameOf(const render::GridField& field) override;
    Result<std::shared_ptr<const render::GridField>> openGrid(const Name& name) override;
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

}  // namespace mote::server
