// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticleStep: one step of a particle plot, memory-mapped: octree, leaves, points and density volume. Opened
// from its digest, which knows where each array lies in the HDF5 file, so that no HDF5 code runs on it.
// Octree and leaves, whose numbers index other things, are copied; points and volume are read where they lie,
// and whoever writes into the file meanwhile changes them under their reader until check() tells. Immutable
// and safe to use from any number of threads; shared by the catalogue and the renderers.
//
// Space: the plot's box [0, 1]^3 for the octree; layer space is that box scaled to [-1, 1]^3.
// Every accessor verifies the MiB blocks that it returns, at their first use, and throws StorageError
// (corrupt, naming file, array and offset) if they differ from the digest. Layout: docs/FORMAT.md.
//
// Opened with a budget (block_budget.h), the blocks come and go: an accessor waits for what is not in memory,
// and the functions ...Ready say what it need not wait for. Without one, all counts as ready. A span is good
// until the generation of the budget ends in which it was asked for, one of octree and leaves as long as its
// keeper; one asks for no more at once than the budget holds.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/log_density.h"
#include "storage/files/path_beneath.h"

namespace mote::storage {

struct PointRange {
    std::uint64_t begin = 0;  ///< in the order of the leaves
    std::uint64_t count = 0;
    bool operator==(const PointRange&) const = default;
};

/// What of a step a picture would use if it were in memory. A value; the plan makes it, StepLoader
/// brings it in: preview, volume, octree, then the points, the ranges in their order.
struct StepNeed {
    std::uint64_t preview = 0;            ///< points of it, from the first
    bool volume = false;                  ///< all of it
    bool octree = false;                  ///< octree and leaves, whole and checked
    std::vector<PointRange> points = {};  ///< the most urgent first

    bool empty() const { return preview == 0 && !volume && !octree && points.empty(); }
    bool operator==(const StepNeed&) const = default;
};

class BlockBudget;

/// The octree's nodes, at least the root, breadth first; the children of a node stand side by side, in Morton
/// order.
struct OctreeNodes {
    std::span<const std::uint8_t> level;    ///< 0: the root, the whole box
    std::span<const std::uint64_t> morton;  ///< of the cell at its level, x in bit 0, y in bit 1, z in bit 2
    std::span<const std::uint32_t> firstChild;  ///< a node; in a leaf (childCount 0) its index in Leaves
    std::span<const std::uint8_t> childCount;   ///< children that hold particles, 0 to 8
    std::span<const std::uint64_t> count;       ///< particles below
    std::span<const float> density;             ///< weight below, over the cell's share of the box
    std::span<const float> minDensity;          ///< least density of a leaf below
    std::shared_ptr<const void> keeper = {};    ///< keeps their memory, if the step may give it up

    std::size_t size() const { return level.size(); }
};

/// The leaves in ascending density: the halo first, the core last.
struct Leaves {
    std::span<const std::uint32_t> node;        ///< index in OctreeNodes
    std::span<const std::uint64_t> pointBegin;  ///< ascending, without gaps
    std::span<const std::uint32_t> pointCount;  ///< at least 1
    std::span<const float> density;             ///< ascending
    std::shared_ptr<const void> keeper = {};    ///< as OctreeNodes::keeper

    std::size_t size() const { return node.size(); }
};

/// One point: its place in its leaf's cell, the cell's edge being 65536; it lies at (p + 1/2) / 65536 of the
/// edge.
struct PackedPosition {
    std::uint16_t x, y, z;
};
static_assert(sizeof(PackedPosition) == 6);

/// A point of the preview: its place in the plot's whole box, the box' edge being 65536; it lies at
/// (p + 1/2) / 65536 of the edge.
struct PreviewPoint {
    std::uint16_t x, y, z;
    std::uint16_t density;  ///< of its leaf: 65535 times Preview::scale.ofLeaf, rounded
};
static_assert(sizeof(PreviewPoint) == 8);

/// Points that can be drawn without the octree: those of least `drawnFrom` (protocol/scene/drawn_points.h),
/// ascending, so every prefix is an unbiased sample of the step.
struct Preview {
    static constexpr std::size_t mostPoints = std::size_t{1} << 23;
    static constexpr std::size_t blockPoints = 4096;

    std::span<const PreviewPoint> points;  ///< the first of `total`
    std::uint64_t total = 0;               ///< at most mostPoints, and no more than a quarter of the step's
    std::span<const float> threshold;      ///< drawnFrom of the first point of each of total's blocks
    LogDensity scale;                      ///< the step's own: its least density above zero, its greatest
};

class ParticleStep {
  public:
    /// `directory` is the dataset; checks the digest's shapes against each other and the file's size.
    /// Errors: notFound, corrupt.
    static Result<std::shared_ptr<const ParticleStep>> open(const PathBeneath& directory,
                                                            const proto::Manifest& manifest,
                                                            std::uint32_t step,
                                                            std::shared_ptr<BlockBudget> budget = nullptr);
    virtual ~ParticleStep() = default;

    /// What checkOctree() lets pass (octree_check.h): it is traversed without looking again.
    virtual OctreeNodes nodes() const = 0;
    virtual Leaves leaves() const = 0;
    virtual std::uint64_t pointCount() const = 0;
    /// Points [begin, begin + count) in the order of the leaves; within a leaf a shuffle, so a prefix is a
    /// sample.
    virtual std::span<const PackedPosition> positions(std::uint64_t begin, std::uint64_t count) const = 0;
    /// Each point's row in its source file.
    virtual std::span<const std::uint64_t> rows(std::uint64_t begin, std::uint64_t count) const = 0;
    /// D^3 densities, x fastest, weight over the cell's share of the box; the cells are those of octree level
    /// log2(D), counted from the particles themselves.
    virtual std::span<const float> volume() const = 0;
    virtual std::uint32_t volumeSize() const = 0;  ///< D
    /// The first `most` points of the preview, or as many as it has: none in a step of few points, nor in one
    /// that was written without. Needs nothing of the octree.
    virtual Preview preview(std::uint64_t most) const {
        static_cast<void>(most);
        return {};
    }

    /// The plot's density scale, the same for all steps.
    virtual LogDensity logDensity() const = 0;

    /// Whether nodes() and leaves() return at once.
    virtual bool octreeReady() const { return true; }
    virtual bool volumeReady() const { return true; }
    /// How many of these points, from the first, positions() returns at once.
    virtual std::uint64_t positionsReady(std::uint64_t begin, std::uint64_t count) const {
        static_cast<void>(begin);
        return count;
    }
    /// The greatest `most`, no greater than this one, that preview() answers at once.
    virtual std::uint64_t previewReady(std::uint64_t most) const { return most; }
    /// Called at the end of each picture: throws StorageError if what was read may have been something
    /// else: the file was truncated or changed under the mapping, or a block that was to come in is damaged.
    virtual void check() const {}
};

}  // namespace mote::storage
