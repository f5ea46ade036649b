// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointOutput: the points of a built step, from the ranks that have them to their places in the file, window
// by window; and the candidates for the preview on the way. One object a step and rank, used from one thread;
// works on all threads of its arena.
//
// The preview of a step: the points that are drawn first as the drawn fraction grows, with all that drawing
// them needs. Gathered while points are written, then put in order; docs/FORMAT.md. PreviewSelection is
// immutable and safe on any number of threads.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "preprocess/particles/octree.h"
#include "preprocess/particles/range_builder.h"
#include "preprocess/particles/step_builder.h"
#include "storage/particles/particle_step.h"
#include "storage/particles/step_file.h"

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

class PointOutput {
  public:
    /// All references outlive this.
    PointOutput(const BuiltStep& step, const storage::StepFile& file, Communicator& ranks,
                std::function<bool()> cancelled);

    /// Writes the points of all windows. Errors: resourceExhausted (disk full), cancelled, internal; the same
    /// on all ranks.
    Status run();

    /// The preview on rank 0, after run(); empty on the others. Errors: cancelled.
    Result<BuiltPreview> preview();

  private:
    /// Points of the file that are gathered and written at once.
    struct Window {
        std::uint64_t begin, end;
    };
    /// A thread's memory.
    struct Worker {
        std::vector<LeafPoint> gathered, buffer;
        std::vector<storage::PackedPosition> positions;
        std::vector<std::uint64_t> rows;
    };

    std::size_t windowCount() const;
    Window window(std::size_t index) const;
    template <class Use>
    void forEachPart(const Window& window, Use use) const;
    std::size_t rankOf(std::size_t leaf) const;
    Status runAlone();
    Status runRound(std::size_t first, std::size_t last);
    Result<std::vector<Bytes>> gatherRound(std::size_t first, std::size_t last);
    Status gather(const Window& window, Worker& worker) const;
    Status write(std::size_t index, std::vector<std::span<const LeafPoint>> streams, Worker& worker);

    const BuiltStep& step_;
    const storage::StepFile& file_;
    Communicator& ranks_;
    std::function<bool()> cancelled_;
    PreviewSelection selection_;
    std::vector<std::vector<PreviewCandidate>> candidates_;  ///< by window
};

}  // namespace mote::prep
