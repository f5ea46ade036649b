// SPDX-License-Identifier: GPL-3.0-or-later
//
// thickMatter: how much of each leaf of a step is thick enough to be shown as a volume (docs/PICTURE.md,
// "Volume", "Share"): sheets, threads, screens and lumps are not, nor what is alone among points, nor the
// edges of what is dense. Pure; uses all threads of the calling arena.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/plan/matter/cell_grid.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// What a picture shows of a step's leaves, by leaf.
struct ShownLeaves {
    std::vector<std::uint8_t> seen;  ///< not 0: the transfer function shows something of it
    float thinnest;                  ///< the least density of those that are seen
    std::vector<float> points;       ///< how much of it is points, if it is thinner; else 0
};

/// By leaf, in 255ths; 255 of those that are not seen. `grid`: the volume's cells, around [low, high) of the
/// deepest level. Throws storage::StorageError.
std::vector<std::uint8_t> thickMatter(const storage::ParticleStep& step, const ShownLeaves& shown,
                                      const CellGrid& grid, const glm::uvec3& low, const glm::uvec3& high);

}  // namespace mote::render
