// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepSpeeds: how fast the points of a step go along those axes of their plot that are places, by their
// momenta. A value; as point_data.h.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "server/render/layers/particles/point_data.h"
#include "storage/numbers/run_steps.h"

namespace mote::render {

class StepSpeeds {
  public:
    /// `seconds`: from the step to another one.
    StepSpeeds(const proto::ParticlesManifest& plot, double seconds);

    bool any() const;
    /// By point: how far it would go meanwhile, in parts of the box; 0 along other axes. Nothing where it was
    /// told to stop.
    std::optional<std::vector<glm::vec3>> of(const storage::StepNumbers& step,
                                             const Cancelled& cancelled) const;

  private:
    glm::vec3 speedOf(const glm::dvec3& momentum) const;

    double mass_;
    std::array<int, 3> momentum_{-1, -1, -1};  // along each axis; below 0: none
    std::array<double, 3> scale_{};
};

}  // namespace mote::render
