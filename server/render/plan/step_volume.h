// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepVolume: what a step's leaves show of themselves as a volume, counted into cells (docs/PICTURE.md,
// "Volume"): made of the leaves and a transfer function, so that the optical depth of a ray is that of the
// leaves as boxes of their own density, whatever the cells. The cube root of extinction is what is
// interpolated: what is dense ends where its cells do, and not where the cells beyond begin to hold nothing,
// which would be seen as steps. Immutable once made; shared by the pictures of a step in one style; safe on
// any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/transfer_function.h"
#include "server/render/plan/point_values.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

struct StepVolume {
    static constexpr unsigned deepest = 12;                             ///< level of cells
    static constexpr std::uint64_t mostCells = std::uint64_t{1} << 21;  ///< in all

    unsigned level = 0;            ///< cells are those of this level of the octree
    glm::uvec3 first{0}, size{1};  ///< the cells that there are, from the first
    /// At the centre of each cell, x fastest: the cube root of the extinction per unit length of layer space.
    /// It is interpolated, and cubed there.
    std::vector<float> root = {};
    /// Gives a cell its colour, 0 to 1: scaled log density, or a share of a range.
    std::vector<float> t = {};
    /// How much of the extinction in a cell and the 26 around it lies in the volume. Empty: all.
    std::vector<float> held = {};
    /// By leaf, in 255ths: how much of what the transfer function shows of it lies in the volume, what is
    /// left being points, as it is too thin for the cells. Empty: all of all leaves.
    std::vector<std::uint8_t> share = {};

    bool empty() const { return root.empty(); }
    std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
        return (std::size_t{z} * size.y + y) * size.x + x;
    }
    /// Its box [0, 1]^3 to the plot's.
    glm::dmat4 toPlot() const;
    /// How far points in a place of the plot's box [0, 1]^3 have the volume's t, and this: interpolated
    /// between the cells' centres. Not where it is empty.
    struct PointTone {
        double held = 1.0, t = 0.0;
    };
    PointTone toneAt(const glm::dvec3& inPlot) const;
    /// Of what a leaf has, 0 to 1.
    double shareOf(std::size_t leaf) const { return share.empty() ? 1.0 : share[leaf] / 255.0; }
    std::uint64_t bytes() const;
};

/// From the octree; empty where it shows nothing. `fraction`: t -> how much of a leaf is points (a volume is
/// no volume where it is alone among them). `values`: by leaf, that colour it in place of its t; a leaf
/// without one lies in no part in the volume. Throws storage::StorageError.
StepVolume stepVolume(const storage::ParticleStep& step, const TransferFunction& transfer,
                      const Curve& fraction, const PointValues* values = nullptr);

/// From the step's own volume, whose cells are taken as leaves: while the octree is not in memory. Throws
/// storage::StorageError.
StepVolume roughStepVolume(const storage::ParticleStep& step, const TransferFunction& transfer);

}  // namespace mote::render
