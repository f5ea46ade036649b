// SPDX-License-Identifier: GPL-3.0-or-later
//
// The preview of a step: the points that are drawn first as the drawn fraction grows, with all that drawing
// them needs. A pure function of what the step file holds; docs/FORMAT.md.
#pragma once

#include <vector>

#include "storage/particles/particle_step.h"

namespace mote::prep {

struct BuiltPreview {
    std::vector<storage::PreviewPoint> points;
    std::vector<float> threshold;  ///< by storage::Preview::blockPoints of them
};

/// A quarter of the points, at most Preview::mostPoints. Uses all threads of the calling arena, with the same
/// result for any number.
BuiltPreview buildPreview(const storage::OctreeNodes& nodes, const storage::Leaves& leaves,
                          std::span<const storage::PackedPosition> positions);

}  // namespace mote::prep
