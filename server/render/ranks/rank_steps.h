// SPDX-License-Identifier: GPL-3.0-or-later
//
// RankSteps: how ranks tell each other of the steps of a picture. Each rank has its own and asks it from the
// thread that draws.
#pragma once

#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "server/render/plan/grid_field.h"
#include "storage/blocks/block_budget.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

class RankSteps {
  public:
    /// The same on all ranks, however each of them reaches the file.
    struct Name {
        std::string file;    ///< "ROOT/NAME.mote/step-000000.h5"
        std::string digest;  ///< as StepOrigin's
        /// What is drawn of a field of samples; never `best`.
        HybridRepresentation parts = HybridRepresentation::volume;
        /// The points of the step that are drawn: a proto::Selection, serialised; empty: all.
        std::string selection = {};
        bool operator==(const Name&) const = default;
    };

    virtual ~RankSteps() = default;
    /// Errors: unsupported (the step lies in no file beneath a root).
    virtual Result<Name> nameOf(const storage::ParticleStep& step) = 0;
    /// Errors: of ParticleStep::open; corrupt if the file is not the one that was named.
    virtual Result<std::shared_ptr<const storage::ParticleStep>> open(const Name& name) = 0;
    /// Likewise of fields of samples; `parts` is told by who draws.
    virtual Result<Name> nameOf(const GridField& field) = 0;
    /// Whole. Errors: of loadHybrid; corrupt if the dataset is not the one that was named,
    /// resourceExhausted.
    virtual Result<std::shared_ptr<const GridField>> openGrid(const Name& name) = 0;
    /// What its steps count to, and what is made of them; null: nobody counts.
    virtual std::shared_ptr<storage::BlockBudget> budget() const { return nullptr; }
    /// Before a picture's first step: what the one before it held may leave memory.
    virtual void beginPicture() {}
};

}  // namespace mote::render
