// SPDX-License-Identifier: GPL-3.0-or-later
//
// A step's octree, points and volume from its particles: what goes into the step file. Pure, but for
// progress.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "preprocess/particles/octree.h"
#include "preprocess/particles/preview.h"
#include "preprocess/particles/quantized_step.h"
#include "storage/particles/step_content.h"

namespace mote::prep {

struct StepOptions {
    OctreeOptions octree;
    std::uint32_t volumeLevel = 0;  ///< 1 to 8
};

struct BuiltStep {
    Octree octree;
    std::vector<storage::PackedPosition> position;  ///< in the order of the leaves
    std::vector<std::uint64_t> row;
    std::vector<float> volume;
    std::uint32_t volumeSize = 0;
    BuiltPreview preview;

    /// Views of these arrays; axes and bounds are the caller's to add.
    storage::StepContent content() const;
};

/// The most memory that building a step takes, bytes: measured, docs/FORMAT.md.
std::uint64_t buildMemory(std::uint64_t particles, const StepOptions& options);

/// Uses all threads of the calling arena, with the same result for any number. Errors: as buildOctree,
/// cancelled.
Result<BuiltStep> buildStep(QuantizedStep particles, const StepOptions& options,
                            const std::function<bool()>& cancelled);

}  // namespace mote::prep
