// SPDX-License-Identifier: GPL-3.0-or-later
//
// ResidentSteps: what a device keeps of steps in its memory, the least recently used given up first. It holds
// no step alive. Owned by the device; used while its context is current.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <list>
#include <memory>
#include <optional>
#include <vector>

#include "server/render/egl/gl_objects.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/step_volume.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// A run of points with what a frame draws of them.
struct PointChunk {
    GlBuffer points;  ///< uvec4 each: place in units of 2^-31 of the box; leaf, counted from firstLeaf
    GlTexture pointsTexture;
    GlBuffer selected;  ///< ChunkSelection::numbers
    GlTexture selectedTexture;
    GlBuffer weights;  ///< ChunkSelection::weights
    GlTexture weightsTexture;
    std::uint64_t lastUse = 0;  ///< counted by ResidentSteps

    std::size_t bytes() const { return points.bytes() + selected.bytes() + weights.bytes(); }
};

/// What a frame draws of a chunk: either its points one by one, if they are few, or blocks of it.
struct ChunkSelection {
    bool listed = false;
    std::size_t firstLeaf = 0;  ///< of its first point
    /// Listed: points of the chunk. Otherwise, of each leaf, the point of the chunk before which it is drawn.
    std::vector<std::uint32_t> numbers;
    std::vector<std::uint32_t> wholeBlocks;  ///< not listed: the blocks of which all points are drawn
    std::vector<std::uint32_t> partBlocks;   ///< and those of which some are
    std::vector<float> weights;              ///< of each leaf's points, if they differ
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

    /// Which points are drawn from now on. Cheap if they are the same as before.
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

/// A texture of pairs, the cube root of extinction and t, as shaders read a volume of so many cells.
GlTexture volumeTexture(const glm::uvec3& size, const glm::vec2* cells);

/// A volume as a texture, and the bricks of its cells in which something is seen.
class GridVolume {
  public:
    /// Throws DeviceError.
    explicit GridVolume(const StepVolume& grid);

    GLuint texture() const { return texture_.get(); }
    /// A brick's edges, as shares of the box's.
    glm::vec3 brickEdge() const { return static_cast<float>(brickCells_) / glm::vec3(size_); }
    /// Packed as x | y << 10 | z << 20.
    const std::vector<std::uint32_t>& visibleBricks() const { return visible_; }
    std::size_t bytes() const { return std::size_t{size_.x} * size_.y * size_.z * sizeof(glm::vec2); }

  private:
    bool brickSeen(const StepVolume& grid, const glm::uvec3& brick) const;

    GlTexture texture_;
    glm::uvec3 size_;
    std::uint32_t brickCells_;
    std::vector<std::uint32_t> visible_;
};

struct ResidentStep {
    std::weak_ptr<const storage::ParticleStep> step;
    const storage::ParticleStep* key;
    StepPoints points;
};

class ResidentSteps {
  public:
    explicit ResidentSteps(std::uint64_t budget) : budget_(budget) {}

    /// Made if it is not there. The reference stays valid until dropExpired().
    ResidentStep& of(const std::shared_ptr<const storage::ParticleStep>& step);
    /// A chunk with the current selection; others are given up if the budget asks for it.
    const PointChunk& chunk(ResidentStep& resident, std::size_t index);
    /// Made if it is not there. The reference stays valid until dropExpired(). Throws DeviceError.
    const GridVolume& volume(const std::shared_ptr<const StepVolume>& grid);
    void dropExpired();
    std::uint64_t bytes() const;

  private:
    /// Gives up the least recently used until the budget is kept, but never what was used last.
    void makeRoom();

    std::uint64_t budget_;
    std::uint64_t uses_ = 0;
    std::list<ResidentStep> steps_;
    struct ResidentVolume {
        std::weak_ptr<const StepVolume> grid;
        const StepVolume* key;
        GridVolume volume;
    };
    std::list<ResidentVolume> volumes_;
};

}  // namespace mote::render
