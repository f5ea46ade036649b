// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepPoints: the points of one step in the device's memory, chunk by chunk, each uploaded when first one of
// its points is drawn (the halo, at the head of the file, comes first). Owned by the device's ResidentSteps;
// used while its context is current. It does not keep the step.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/render/egl/gl_objects.h"
#include "server/render/plan/frame_plan.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// A run of points with what a frame draws of them.
struct PointChunk {
    GlBuffer points;  ///< uvec4 each: place in units of 2^-31 of the box; leaf, counted from firstLeaf
    GlTexture pointsTexture;
    GlBuffer selected;  ///< ChunkSelection::numbers
    GlTexture selectedTexture;
    std::uint64_t lastUse = 0;  ///< counted by ResidentSteps

    std::size_t bytes() const { return points.bytes() + selected.bytes(); }
};

/// What a frame draws of a chunk: either its points one by one, where they are few, or blocks of it.
struct ChunkSelection {
    bool listed = false;
    std::size_t firstLeaf = 0;  ///< of its first point
    /// Listed: points of the chunk. Otherwise, of each leaf, the point of the chunk before which it is drawn.
    std::vector<std::uint32_t> numbers;
    std::vector<std::uint32_t> wholeBlocks;  ///< not listed: the blocks of which all points are drawn
    std::vector<std::uint32_t> partBlocks;   ///< and those of which some are
    bool uploaded = false;

    bool empty() const { return numbers.empty() || (!listed && wholeBlocks.empty() && partBlocks.empty()); }
};

class StepPoints {
  public:
    static constexpr std::uint64_t chunkPoints = 1U << 20;
    static constexpr std::uint32_t blockPoints = 256;  ///< a workgroup's

    explicit StepPoints(const storage::ParticleStep& step);

    /// Which points are drawn from now on. Cheap where they are the same as before.
    void select(const PointsPlan& layer);

    std::size_t chunkCount() const { return chunks_.size(); }
    const ChunkSelection& selection(std::size_t chunk) const { return selected_[chunk]; }
    bool resident(std::size_t chunk) const { return chunks_[chunk].has_value(); }
    /// Uploads what is missing. Throws DeviceError, storage::StorageError.
    PointChunk& load(const storage::ParticleStep& step, std::size_t chunk);
    void evict(std::size_t chunk) { chunks_[chunk].reset(); }
    const std::optional<PointChunk>& at(std::size_t chunk) const { return chunks_[chunk]; }

  private:
    void selectChunk(const PointsPlan& layer, const storage::Leaves& leaves, std::size_t chunk);

    std::uint64_t pointCount_;
    std::vector<std::optional<PointChunk>> chunks_;
    std::vector<ChunkSelection> selected_;
    // What is selected; null: nothing is.
    std::shared_ptr<const PointSelection> selection_;
    std::vector<std::uint64_t> leavesInView_;
};

}  // namespace mote::render
