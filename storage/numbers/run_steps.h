// SPDX-License-Identifier: GPL-3.0-or-later
//
// RunSteps: where questions for numbers find the steps of a run: a selection that was made in one step asks
// for that step also while another is looked at. Any number of threads.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/quantity/known_quantity.h"
#include "storage/particles/particle_columns.h"
#include "storage/particles/particle_step.h"

namespace mote::storage {

using mote::BeamContext;

/// A step's points and what lies beside them.
struct StepNumbers {
    std::shared_ptr<const ParticleStep> points;
    std::shared_ptr<const ParticleColumns> columns;  ///< null: the dataset was made without
    BeamContext context;
};

/// What is said at a field that needs columns, or ids, where a dataset has none.
Error withoutColumns(std::string where);
Error withoutIds(std::string where);

class RunSteps {
  public:
    virtual ~RunSteps() = default;
    virtual const proto::ParticlesManifest& manifest() const = 0;
    /// Errors: notFound (no such step), corrupt, permissionDenied.
    virtual Result<StepNumbers> step(std::uint32_t index) const = 0;
};

}  // namespace mote::storage
