// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepGrid: a field of samples in the device's memory: the samples of its coarse grid and
// of the bricks in which that is corrected, four texels of 16 bytes for sixteen cells along x. Owned by the
// device's ResidentGrids; used while its context is current.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "server/render/egl/gl_objects.h"
#include "server/render/egl/pacer.h"
#include "server/render/plan/grid_field.h"

namespace mote::render {

class StepGrid {
  public:
    static constexpr std::uint32_t brickEdge = GridBricks::edge;  ///< cells of the grid

    /// `corrected`: with the step's bricks, which must be there. Empty where the frame is given up meanwhile.
    /// Throws DeviceError, also where the device cannot hold it.
    static std::optional<StepGrid> load(const GridField& step, bool corrected, const Pacer& pacer);

    /// The coarse grid, x fastest, then brick after brick, as shaders/grid.glsl reads them.
    GLuint samples() const { return samplesTexture_.get(); }
    /// Samples along the axes of the grid that is cut into bricks: the error grid, or the coarse grid.
    const glm::uvec3& grid() const { return grid_; }
    std::size_t bytes() const { return samples_.bytes(); }

  private:
    StepGrid(const GridField& step, const GridBricks* bricks);
    bool upload(const GridField& step, const GridBricks* bricks, const Pacer& pacer);

    GlBuffer samples_;
    GlTexture samplesTexture_;
    glm::uvec3 grid_;
};

}  // namespace mote::render
