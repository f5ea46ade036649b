// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/grid/volume_samples.h"

namespace mote::render {

VolumeSamples::VolumeSamples(const GridField& field, bool corrected)
    : field_(field),
      bricks_(corrected ? field.bricks.get() : nullptr),
      cells_(bricks_ != nullptr ? bricks_->size : field.coarse.size),
      last_(cells_ - 1.0),
      coarse_(glm::dvec3(field.coarse.size) / cells_),
      coarseLast_(field.coarse.size - 1U),
      coarseStrides_{field.coarse.size.x, std::size_t{field.coarse.size.x} * field.coarse.size.y} {}

glm::vec3 VolumeSamples::slope(const glm::vec3& place) const {
    const bool fine = brickAt(sampleAt(place)) != GridBricks::none;
    glm::vec3 slope(0.0F);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 off(0.0F);
        off[axis] = fine ? 1.0F : 1.0F / coarse_[axis];
        slope[axis] = (code(place + off) - code(place - off)) / (2.0F * off[axis]);
    }
    return slope;
}

}  // namespace mote::render
