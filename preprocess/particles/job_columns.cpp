// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/job_columns.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace mote::prep {

Result<JobColumns> JobColumns::make(const proto::ParticlesJob& job, const ParticleSource& source) {
    JobColumns columns;
    const bool marked = lostParticlesOf(source, job) == LostParticles::with;
    MOTE_ASSIGN_OR_RETURN(columns.kept_, keptColumns(job.columns(), source, marked));
    return columns;
}

void JobColumns::describe(const ParticleSource& source, proto::ParticlesManifest& manifest) const {
    for (const auto& column : kept_.columns) {
        auto& entry = *manifest.add_columns();
        entry.set_name(column.name);
        entry.set_unit(column.unit);
        // Nothing yet: the first step's range is taken as it is.
        entry.set_min(0.0);
        entry.set_max(-1.0);
    }
    manifest.set_ids(kept_.ids);
    manifest.set_mass(source.mass());
    manifest.set_species(source.species());
    manifest.set_particle_charge(source.particleCharge());
    manifest.set_weight_unit(source.weightUnit());
}

std::vector<Column> JobColumns::sources() const {
    std::set<Column> all;
    for (const auto& column : kept_.columns) {
        const auto own = column.sources();
        all.insert(own.begin(), own.end());
    }
    return {all.begin(), all.end()};
}

Status JobColumns::write(ColumnsRequest request, proto::ParticlesManifest& manifest,
                         proto::ParticleStepEntry& entry) const {
    request.kept = &kept_;
    MOTE_ASSIGN_OR_RETURN(const auto written, writeColumns(request));
    entry.set_columns_file(request.name + ".h5");
    entry.set_columns_digest(request.name + ".digest");
    entry.mutable_column_resolution()->Assign(written.resolutions.begin(), written.resolutions.end());
    for (std::size_t i = 0; i < kept_.columns.size(); ++i) {
        auto& column = *manifest.mutable_columns(static_cast<int>(i));
        entry.add_column_offset(written.codings[i].offset);
        if (written.codings[i].doubles) column.set_type("f64");
        const auto range = Range{column.min(), column.max()}.united({written.least[i], written.greatest[i]});
        column.set_min(range.min);
        column.set_max(range.max);
    }
    return success();
}

}  // namespace mote::prep
