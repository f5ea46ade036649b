// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepContent: what a step file is to hold, as views of arrays that the job owns; StepShape: how much that
// is. Values.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "storage/particles/particle_step.h"
#include "storage/particles/step_layout.h"

namespace mote::storage {

/// What a step file says of itself beside its arrays.
struct StepAttributes {
    std::array<std::string, 3> axes;
    std::array<double, 3> boundsMin{};  ///< in the axes' units
    std::array<double, 3> boundsMax{};
    double totalWeight = 0.0;  ///< of the particles in leaves
};

struct StepShape {
    std::uint64_t nodes = 0;
    std::uint64_t leaves = 0;
    std::uint64_t points = 0;
    std::uint64_t previewPoints = 0;
    std::uint32_t volumeSize = 0;

    /// The extents of an array, slowest first.
    std::vector<std::uint64_t> of(StepArray which) const;
};

struct StepContent : StepAttributes {
    OctreeNodes nodes;
    Leaves leaves;
    std::span<const PackedPosition> positions;  ///< in the order of the leaves
    std::span<const std::uint64_t> rows;        ///< as many
    std::span<const float> volume;              ///< volumeSize^3, x fastest
    std::uint32_t volumeSize = 0;
    std::span<const PreviewPoint> previewPoints;
    std::span<const float> previewThreshold;  ///< one for each Preview::blockPoints of them, or a part
};

}  // namespace mote::storage
