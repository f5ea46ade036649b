// SPDX-License-Identifier: GPL-3.0-or-later
//
// The preview of a step: the points that are drawn first as the drawn fraction grows, with all that drawing
// them needs. Gathered while points are written, then put in order; docs/FORMAT.md. PreviewSelection is
// immutable and safe on any number of threads.
#pragma once

#include <span>
#include <vector>

#include "preprocess/particles/octree.h"
#include "storage/particles/particle_step.h"

namespace mote::prep {

struct PreviewCandidate {
    double from;  ///< the fraction that draws it
    storage::PreviewPoint point;
};

struct BuiltPreview {
    std::vector<storage::PreviewPoint> points;
    std::vector<float> threshold;  ///< by storage::Preview::blockPoints of them
};

/// A quarter of the points, at most Preview::mostPoints.
std::uint64_t previewSize(std::uint64_t points);

class PreviewSelection {
  public:
    /// `octree` outlives this. Uses all threads of the calling arena.
    explicit PreviewSelection(const Octree& octree);

    /// Appends those of a leaf's points that may be in the preview: `positions` are its points from `first`
    /// on.
    void add(std::size_t leaf, std::uint32_t first, std::span<const storage::PackedPosition> positions,
             std::vector<PreviewCandidate>& candidates) const;

    /// Chooses among all leaves' candidates, list after list and in each leaf by leaf in their order. The
    /// same for any number of threads.
    BuiltPreview choose(const std::vector<std::span<const PreviewCandidate>>& lists) const;

  private:
    double fractionFor(std::uint64_t total) const;

    const Octree& octree_;
    std::uint64_t total_ = 0;
    double fraction_ = 0.0;  ///< draws all of the preview, and few points more
    LogDensity scale_;       ///< of the leaves that weigh anything
};

}  // namespace mote::prep
