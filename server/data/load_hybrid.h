// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is loaded of fields of samples: hybrid volumes, and the density of particles that ink draws. Values;
// `entry` is one of the catalogue's.
#pragma once

#include <cstdint>

#include "server/data/loadable.h"
#include "server/render/plan/grid_field.h"

namespace mote::server {

/// A step's density, smoothed (server/render/layers/ink/density_grid.h). Errors: invalidArgument (a dataset
/// of another kind).
Result<Loadable<render::GridField>> stepDensity(const storage::Catalogue::Entry& entry, std::uint32_t step);

/// A step of a series, with what a representation draws. Errors: invalidArgument (a dataset of another kind),
/// unsupported (it has no such representation).
Result<Loadable<render::GridField>> hybridStep(const storage::Catalogue::Entry& entry, std::uint32_t step,
                                               HybridRepresentation representation);

/// Its coarse grid alone, for as long as the rest is on its way; those of other steps are not
/// loaded ahead. Errors: the same.
Result<Loadable<render::GridField>> hybridVolume(const storage::Catalogue::Entry& entry, std::uint32_t step);

}  // namespace mote::server
