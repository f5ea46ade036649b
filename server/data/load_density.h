// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is loaded of particles that are drawn as a field of their density. A value; `entry` is one of the
// catalogue's.
#pragma once

#include <cstdint>

#include "server/data/loadable.h"
#include "server/render/plan/grid_field.h"

namespace mote::server {

/// A step's density, smoothed (server/render/layers/ink/density_grid.h). Errors: invalidArgument (a dataset
/// of another kind).
Result<Loadable<render::GridField>> stepDensity(const storage::Catalogue::Entry& entry, std::uint32_t step);

}  // namespace mote::server
