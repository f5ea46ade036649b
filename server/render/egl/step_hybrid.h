// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepHybrid: a step of a hybrid volume in the device's memory: the samples of its low-resolution volume and
// of the bricks in which that is corrected, a word and a half each; with the range of the values in each
// brick, which tells where nothing can be seen. Owned by the device's ResidentHybridSteps; used while its
// context is current.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "server/render/cpu/volume_blocks.h"
#include "server/render/egl/gl_objects.h"
#include "server/render/egl/pacer.h"
#include "server/render/hybrid/hybrid_step.h"
#include "server/render/transfer_table.h"

namespace mote::render {

class StepHybrid {
  public:
    static constexpr std::uint32_t brickEdge = HybridBricks::edge;  ///< cells of the grid

    /// `corrected`: with the step's bricks, which must be there. Empty where the frame is given up meanwhile.
    /// Throws DeviceError, also where the device cannot hold it.
    static std::optional<StepHybrid> load(const HybridStep& step, bool corrected, const Pacer& pacer);

    /// The low volume, x fastest, then brick after brick, as shaders/hybrid.glsl reads them.
    GLuint samples() const { return samplesTexture_.get(); }
    /// The word with which the samples' normals begin.
    std::uint32_t firstNormals() const { return samplesCount_; }
    /// Samples along the axes of the grid that is cut into bricks: the error grid, or the low volume.
    const glm::uvec3& grid() const { return grid_; }
    const glm::uvec3& brickCount() const { return ranges_.count(); }
    /// Of each brick, x fastest: its number among the corrected ones plus 1, or 0; and in the highest bit
    /// whether anything is seen in it.
    std::vector<std::uint32_t> brickWords(const TransferTable& table) const;
    std::size_t bytes() const { return samples_.bytes(); }

  private:
    StepHybrid(const HybridStep& step, const HybridBricks* bricks);
    bool upload(const HybridStep& step, const HybridBricks* bricks, const Pacer& pacer);

    GlBuffer samples_;
    GlTexture samplesTexture_;
    std::uint32_t samplesCount_ = 0;
    glm::uvec3 grid_;
    std::vector<std::int32_t> numbers_;  ///< of bricks among the corrected; empty where none are
    BlockRanges ranges_;                 ///< of what interpolation meets in each brick
};

}  // namespace mote::render
