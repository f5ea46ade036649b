// SPDX-License-Identifier: GPL-3.0-or-later
//
// KeptColumns: which columns of a run a job keeps beside the points of its plot, what is read of the source for
// them, and what the manifest says of them. A value and pure functions.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/particles/plot_axis.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct KeptColumn {
    std::string name, unit;
    std::optional<PlotAxis> axis;  ///< whose values it holds; none: 1 where the particle is lost, else 0

    bool isWeight() const { return name == "weight"; }
    /// What it is made from.
    std::vector<Column> sources() const { return axis ? axis->columns() : std::vector<Column>(); }
};

struct KeptColumns {
    std::vector<KeptColumn> columns;
    bool ids = false;

    bool empty() const { return columns.empty() && !ids; }
    /// What the columns are made from.
    std::vector<Column> sources() const;
    /// What the manifest says before any step's columns are there.
    void describe(const ParticleSource& source, proto::ParticlesManifest& manifest) const;
};

/// For names as in a request ("none": none; no name: all that the run has of x y z t px py pz, weight and
/// id; of a dataset all its columns). Where lost particles are among others, `marked`, their marks are kept.
/// Errors: invalidArgument (no such name, or twice), notFound (the run does not have it).
Result<KeptColumns> keptColumns(const google::protobuf::RepeatedPtrField<std::string>& names,
                                const ParticleSource& source, bool marked = false);

/// A column's value of each particle of a chunk, which has what its sources() name. `out` has the chunk's
/// size.
void evaluateColumn(const KeptColumn& column, const ParticleChunk& chunk, const BeamContext& context,
                    std::span<double> out);

}  // namespace mote::prep
