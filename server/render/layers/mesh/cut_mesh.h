// SPDX-License-Identifier: GPL-3.0-or-later
//
// A mesh without what clips cut away: a drawing in ink is made of it, whose outlines its new borders are.
// Pure; any thread.
#pragma once

#include "protocol/scene/clip.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::render {

/// What lies in all half-spaces of layer space: triangles that go through a side of one become one or two,
/// whose new corners have interpolated normals; parts and intersections stay theirs. It may be empty. Edges
/// are as a dataset has them.
storage::SurfaceMesh cutMesh(const storage::SurfaceMesh& mesh, const HalfSpaces& clips);

}  // namespace mote::render
