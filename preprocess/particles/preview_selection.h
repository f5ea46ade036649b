// SPDX-License-Identifier: GPL-3.0-or-later
//
// The preview of a step: the points that are drawn first as the drawn fraction grows, with all that drawing
// them needs (docs/FORMAT.md). Candidates are gathered while points are written, then put in order, by each
// rank some: the fractions are cut into slices. PreviewSelection is immutable and safe on any number of
// threads.
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

/// A stretch of a preview.
struct BuiltPreview {
    std::uint64_t first = 0;  ///< the place of its first point
    std::vector<storage::PreviewPoint> points;
    std::vector<float> threshold;  ///< of the blocks, storage::Preview::blockPoints each, that begin in it
};

/// A quarter of the points, at most Preview::mostPoints.
std::uint64_t previewSize(std::uint64_t points);

class PreviewSelection {
  public:
    /// All ranks call it, each with its leaves. `octree` outlives this. Uses all threads of the calling
    /// arena. Errors: cancelled.
    static Result<PreviewSelection> make(const Octree& octree, Communicator& ranks);

    /// Appends those of a leaf's points that may be in the preview: `positions` are its points from `first`
    /// on.
    void add(std::size_t leaf, std::uint32_t first, std::span<const storage::PackedPosition> positions,
             std::vector<PreviewCandidate>& candidates) const;

    /// The one of `slices`, equally wide in the fraction, that a candidate is in.
    std::size_t sliceOf(const PreviewCandidate& candidate, std::size_t slices) const;

    /// Puts the candidates of slices [first, last) into `sorted`, which has room for just them, by their
    /// fraction; those of equal ones in the order of the lists, and within a list in its own. The same for
    /// any number of threads.
    void sort(const std::vector<std::span<const PreviewCandidate>>& lists, std::size_t first,
              std::size_t last, std::size_t slices, std::span<PreviewCandidate> sorted) const;

    /// About how many of so many points are candidates.
    std::size_t expected(std::uint64_t points) const {
        return static_cast<std::size_t>(fraction_ * static_cast<double>(points));
    }

    /// What `sorted` candidates, `before` of which are in earlier slices, give to the preview.
    BuiltPreview preview(std::span<const PreviewCandidate> sorted, std::uint64_t before) const;

  private:
    explicit PreviewSelection(const Octree& octree);
    Status findFraction(Communicator& ranks);
    std::uint64_t drawnBy(double fraction) const;

    const Octree& octree_;
    std::uint64_t total_ = 0;
    double fraction_ = 0.0;  ///< draws all of the preview, and few points more
    LogDensity scale_;       ///< of the leaves that weigh anything
};

}  // namespace mote::prep
