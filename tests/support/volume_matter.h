// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a step's volume holds, by many samples: what its interpolation makes of its cells (docs/PICTURE.md,
// "Volume").
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "server/render/plan/step_volume.h"

namespace mote::test {

/// The volume's extinction over its cells, a plot's box being one: its interpolated root, cubed, at 4 x 4 x 4
/// places of each cell.
inline double matterOf(const render::StepVolume& volume) {
    const auto at = [&](const glm::dvec3& place) {  // in cells from the first one's centre
        double sum = 0.0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            const glm::uvec3 high(corner & 1U, corner >> 1 & 1U, corner >> 2);
            const glm::dvec3 low = glm::floor(place), way = place - low;
            const glm::dvec3 share = glm::mix(1.0 - way, way, glm::dvec3(high));
            const glm::ivec3 last(volume.size - 1U);
            const glm::uvec3 cell(glm::clamp(glm::ivec3(low) + glm::ivec3(high), glm::ivec3(0), last));
            sum += share.x * share.y * share.z *
                   static_cast<double>(volume.root[volume.index(cell.x, cell.y, cell.z)]);
        }
        return sum * sum * sum;
    };
    constexpr std::uint32_t fine = 4;
    const glm::uvec3 places = volume.size * fine;
    double sum = 0.0;
    for (std::uint32_t z = 0; z < places.z; ++z) {
        for (std::uint32_t y = 0; y < places.y; ++y) {
            for (std::uint32_t x = 0; x < places.x; ++x)
                sum += at((glm::dvec3(x, y, z) + 0.5) / static_cast<double>(fine) - 0.5);
        }
    }
    return std::ldexp(sum / (fine * fine * fine), -3 * static_cast<int>(volume.level));
}

}  // namespace mote::test
