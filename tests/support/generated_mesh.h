// SPDX-License-Identifier: GPL-3.0-or-later
//
// Meshes for tests: closed, open, creased, crossing themselves, made of needles or leaves, of any
// size and far from their origin. Pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "server/render/layers/mesh/mesh_surface.h"

namespace mote::test {

// The edges of generated meshes, found in the plainest way: by the places of their ends. Pure functions.

/// Where two triangles meet in opposite directions and no other there, one edge; else one for each triangle,
/// with nothing on its other side.
std::vector<storage::MeshEdge> edgesOf(const storage::SurfaceMesh& mesh);

/// A mesh with its edges and bounds.
std::shared_ptr<const render::MeshSurface> surfaceOf(storage::SurfaceMesh mesh);

std::span<const std::string_view> meshForms();

/// `form`: one of meshForms().
std::shared_ptr<const render::MeshSurface> meshOf(const std::string& form, std::uint32_t number,
                                                  std::uint32_t step);

}  // namespace mote::test
