// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepVolume: a step's density volume as a texture of scaled log density, with the range of t in each brick
// of cells, which tells where nothing can be seen. Owned by the device's ResidentSteps; used while its
// context is current.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/render/egl/gl_objects.h"
#include "server/render/egl/pacer.h"
#include "server/render/plan/transfer_table.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// Densities as shaders read them, of so many cells a side.
GlTexture volumeTexture(std::uint32_t size, const float* t);

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

}  // namespace mote::render
