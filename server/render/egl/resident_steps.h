// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentSteps: what a device keeps of steps in its memory, the least recently used given up first. It holds
// no step alive. Owned by the device; used while its context is current.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <vector>

#include "server/render/egl/gl_objects.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/transfer_table.h"
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

/// The points of one step in the device's memory, chunk by chunk, each uploaded when first one of its points
/// is drawn (the halo, at the head of the file, comes first). It does not keep the step.
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

/// Densities as shaders read them, of so many cells a side.
GlTexture volumeTexture(std::uint32_t size, const float* t);

/// A step's density volume as a texture of scaled log density, with the range of t in each brick of cells,
/// which tells where nothing can be seen.
class StepVolume {
  public:
    /// Empty where the frame is given up meanwhile. Throws DeviceError, storage::StorageError.
    static std::optional<StepVolume> load(const storage::ParticleStep& step, const Pacer& pacer);

    GLuint texture() const { return texture_.get(); }
    std::uint32_t size() const { return size_; }
    /// A brick's edge, as a share of the box's.
    double brickEdge() const { return static_cast<double>(brickCells_) / size_; }
    /// The bricks in which something is visible, packed as x | y << 10 | z << 20.
    std::vector<std::uint32_t> visibleBricks(const TransferTable& table) const;
    std::size_t bytes() const { return std::size_t{size_} * size_ * size_ * sizeof(float); }

  private:
    struct Range {
        float low, high;
    };
    StepVolume(std::uint32_t size, const std::vector<float>& t);

    GlTexture texture_;
    std::uint32_t size_;
    std::uint32_t brickCells_;
    std::uint32_t bricks_;       ///< a side
    std::vector<Range> ranges_;  ///< of t that interpolation meets in the brick, x fastest
};

struct ResidentStep {
    std::weak_ptr<const storage::ParticleStep> step;
    const storage::ParticleStep* key;
    StepPoints points;
    std::optional<StepVolume> volume;
    std::uint64_t volumeUse = 0;
};

class ResidentSteps {
  public:
    explicit ResidentSteps(std::uint64_t budget) : budget_(budget) {}

    /// Made where it is not there. The reference stays valid until dropExpired().
    ResidentStep& of(const std::shared_ptr<const storage::ParticleStep>& step);
    /// A chunk with the current selection; others are given up where the budget asks for it.
    const PointChunk& chunk(ResidentStep& resident, std::size_t index);
    /// Null where the frame is given up meanwhile.
    const StepVolume* volume(ResidentStep& resident, const Pacer& pacer);
    void dropExpired();
    std::uint64_t bytes() const;

  private:
    /// Gives up the least recently used until the budget is kept, but never what was used last.
    void makeRoom();

    std::uint64_t budget_;
    std::uint64_t uses_ = 0;
    std::list<ResidentStep> steps_;
};

}  // namespace mote::render
