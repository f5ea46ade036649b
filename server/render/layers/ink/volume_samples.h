// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeSamples: a grid field's values anywhere in its box, as it is drawn (docs/PICTURE.md, "Hybrid
// volumes"; points are smooth and fully applied), and their slopes. Refers to the field; any number of
// threads.
#pragma once

#include <glm/vec3.hpp>

#include "server/render/plan/grid_field.h"

namespace mote::render {

class VolumeSamples {
  public:
    explicit VolumeSamples(const GridField& field);

    /// Of the finest grid, along each axis. Places are told in its cells from the box's corner.
    const glm::dvec3& cells() const { return cells_; }
    float code(const glm::vec3& place) const;
    /// Codes a cell, by differences as far apart as samples lie there.
    glm::vec3 slope(const glm::vec3& place) const;

  private:
    /// The corrected brick that a place lies in, or GridBricks::none.
    std::int32_t brickAt(const glm::vec3& sample) const;
    /// Samples from the first one's middle, nowhere beyond the last.
    glm::vec3 sampleAt(const glm::vec3& place) const;

    const GridField& field_;
    const GridBricks* bricks_;  // null: the coarse grid is the finest
    glm::dvec3 cells_;
    glm::vec3 last_;    // samples, finest grid
    glm::vec3 coarse_;  // coarse cells a cell
    glm::vec3 coarseLast_;
};

}  // namespace mote::render
