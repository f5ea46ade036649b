// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is loaded of meshes. A value; `entry` is one of the catalogue's.
#pragma once

#include "server/data/loadable.h"
#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::server {

/// Whether a dataset holds a mesh: one of its kind, or a stippled surface, beside its dots.
bool hasMesh(const proto::Manifest& manifest);

/// A mesh to be drawn, without what clips cut away. Errors: invalidArgument (a dataset without one).
Result<Loadable<render::MeshSurface>> meshSurface(const storage::Catalogue::Entry& entry,
                                                  const HalfSpaces& clips = {});

}  // namespace mote::server
