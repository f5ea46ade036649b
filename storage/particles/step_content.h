// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepContent: what a step file is to hold, as views of arrays that the job owns. A value.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "storage/particles/particle_step.h"

namespace mote::storage {

struct StepContent {
    std::array<std::string, 3> axes;
    std::array<double, 3> boundsMin{};  ///< in the axes' units
    std::array<double, 3> boundsMax{};
    double totalWeight = 0.0;  ///< of the particles in leaves
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
