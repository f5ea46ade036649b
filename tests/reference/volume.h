// SPDX-License-Identifier: GPL-3.0-or-later
//
// Volume: what fills a part of layer space, as the reference marches through it. Immutable; safe on any
// number of threads.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/hybrid_style.h"

namespace mote::reference {

struct VolumeMatter {
    double extinction = 0.0;  ///< per unit length of layer space
    glm::dvec3 color{0.0};    ///< linear RGB, with its light
};

class Volume {
  public:
    virtual ~Volume() = default;
    /// At a place in layer space, inside.
    virtual VolumeMatter at(const glm::dvec3& inLayer) const = 0;
    /// In which it lies, all together; layer space. Their normals are of any length.
    virtual std::vector<HalfSpace> within() const = 0;
    /// Of its finest cells, layer units.
    virtual double cellEdge() const = 0;
};

}  // namespace mote::reference
