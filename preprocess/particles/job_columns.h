// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobColumns: the columns that a particles job keeps, from its request to its manifest. Owned by the job,
// used from its thread.
#pragma once

#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/column_output.h"
#include "preprocess/particles/kept_columns.h"
#include "preprocess/particles/lost_filter.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

class JobColumns {
  public:
    /// Errors: as keptColumns.
    static Result<JobColumns> make(const proto::ParticlesJob& job, const ParticleSource& source);

    bool empty() const { return kept_.empty(); }
    /// What the columns are made from.
    std::vector<Column> sources() const;
    /// What the manifest says before any step's columns are there.
    void describe(const ParticleSource& source, proto::ParticlesManifest& manifest) const;
    /// Writes a step's columns; all of `request` but what is kept is given. Fills the step's entry and widens
    /// the columns' ranges. Errors: as writeColumns.
    Status write(ColumnsRequest request, proto::ParticlesManifest& manifest,
                 proto::ParticleStepEntry& entry) const;

  private:
    KeptColumns kept_;
};

}  // namespace mote::prep
