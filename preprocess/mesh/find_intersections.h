// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which triangles of a mesh cut each other: lines of a drawing that are no edges of the mesh. Pure; any
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "storage/mesh/surface_mesh.h"

namespace mote::prep {

/// Pairs of triangles, in order, the lesser first, that cut each other along a line
/// (storage::TriangleIntersections). Where one only lies with an edge on the other, as the corner of a box on
/// the floor does, there is none: the surface must go on beyond. None at all (nullopt) where more are near
/// each other, or cut each other, than is of use (a hundred million and 32 a triangle; four million and eight
/// a triangle), and if `cancelled`.
std::optional<std::vector<std::array<std::uint32_t, 2>>> findIntersections(
    const storage::SurfaceMesh& mesh, const std::function<bool()>& cancelled);

}  // namespace mote::prep
