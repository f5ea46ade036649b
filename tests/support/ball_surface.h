// SPDX-License-Identifier: GPL-3.0-or-later
//
// Surfaces to stipple in tests: a ball of points and triangles, alone or above a floor. Plain functions.
#pragma once

#include <cstdint>
#include <filesystem>

#include "server/render/layers/stipple/stipple_surface.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::test {

/// The unit ball with so many points on it, even at every removal: of any n that are left, each ring of the
/// ball has its share to within a few. Points never move.
render::StippleSurface ballSurface(std::uint32_t points);

/// A square floor of edge 4 at y = -1 with all points, beneath a ball of radius 1/2 at the origin.
render::StippleSurface floorSurface(std::uint32_t points);

/// Publishes the ball as a dataset "NAME.mote" of kind "stipple". Throws StorageError.
void writeBall(const std::filesystem::path& output, std::uint32_t points);
/// The same without points, of kind "mesh".
void writeBallMesh(const std::filesystem::path& output);

}  // namespace mote::test
