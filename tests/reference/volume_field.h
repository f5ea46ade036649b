// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeField: the continuous volume of one layer (docs/PICTURE.md, "Volume"): extinction and colour anywhere
// in layer space. A value that shares its step's numbers; safe on any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/particles_style.h"
#include "storage/particles/particle_step.h"
#include "tests/reference/volume.h"

namespace mote::reference {

class VolumeField final : public Volume {
  public:
    VolumeField(const storage::ParticleStep& step, const ParticlesStyle& style);

    /// Scaled log density at a place in layer space, trilinear between the cells' centres; the nearest value
    /// beyond the outermost centres.
    double t(const glm::dvec3& inLayer) const;
    /// Per unit length of layer space.
    double extinction(double t) const { return transfer_.extinction(t); }
    /// Linear RGB.
    glm::dvec3 color(double t) const { return transfer_.color(t); }
    VolumeMatter at(const glm::dvec3& inLayer) const override;
    std::vector<HalfSpace> within() const override;
    double cellEdge() const override { return 2.0 / size_; }

  private:
    std::uint32_t size_;
    std::vector<double> cells_;  // t of each, x fastest
    TransferFunction transfer_;
};

}  // namespace mote::reference
