// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/volume_field.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace mote::reference {

VolumeField::VolumeField(const storage::ParticleStep& step, const ParticlesStyle& style)
    : size_(step.volumeSize()), transfer_(style.transfer()) {
    const LogDensity scale = step.logDensity();
    for (const float density : step.volume()) cells_.push_back(scale.ofCell(density));
}

double VolumeField::t(const glm::dvec3& inLayer) const {
    std::array<std::size_t, 3> below{}, above{};
    std::array<double, 3> share{};
    for (int axis = 0; axis < 3; ++axis) {
        // Cell i has its centre at i + 1/2 cells from the box's side.
        const double last = size_ - 1.0;
        const double place = std::clamp(0.5 * (inLayer[axis] + 1.0) * size_ - 0.5, 0.0, last);
        below[axis] = static_cast<std::size_t>(place);
        above[axis] = std::min(below[axis] + 1, static_cast<std::size_t>(size_) - 1);
        share[axis] = place - static_cast<double>(below[axis]);
    }
    const auto cell = [&](std::size_t x, std::size_t y, std::size_t z) {
        return cells_[(z * size_ + y) * size_ + x];
    };
    const auto alongX = [&](std::size_t y, std::size_t z) {
        return glm::mix(cell(below[0], y, z), cell(above[0], y, z), share[0]);
    };
    const auto alongY = [&](std::size_t z) {
        return glm::mix(alongX(below[1], z), alongX(above[1], z), share[1]);
    };
    return glm::mix(alongY(below[2]), alongY(above[2]), share[2]);
}

VolumeMatter VolumeField::at(const glm::dvec3& inLayer) const {
    const double here = t(inLayer), extinct = extinction(here);
    // Most of a plot's box is empty, and a colour takes longer than all else.
    if (!(extinct > 0.0)) return {};
    return {extinct, color(here)};
}

std::vector<HalfSpace> VolumeField::within() const {
    std::vector<HalfSpace> sides;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 normal(0.0);
        normal[axis] = 1.0;
        sides.push_back({normal, -1.0});
        sides.push_back({-normal, -1.0});
    }
    return sides;
}

}  // namespace mote::reference
