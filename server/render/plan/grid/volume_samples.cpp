// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/grid/volume_samples.h"

#include <algorithm>

namespace mote::render {

VolumeSamples::VolumeSamples(const GridField& field, bool corrected) {
    grids_.coarse = &field.coarse;
    grids_.bricks = corrected ? field.bricks.get() : nullptr;
    cells_ = grids_.bricks != nullptr ? grids_.bricks->size : field.coarse.size;
    grids_.last = cells_ - 1.0;
    grids_.coarseScale = glm::dvec3(field.coarse.size) / cells_;
    grids_.coarseLast = field.coarse.size - 1U;
}

glm::vec3 VolumeSamples::slope(const glm::vec3& place) const {
    glm::vec3 slope;
    slopes({&place, 1}, {&slope, 1});
    return slope;
}

void VolumeSamples::slopes(std::span<const glm::vec3> places, std::span<glm::vec3> slopes) const {
    constexpr std::size_t sides = 6, together = SamplePlaces::most / sides;
    SampleCodes found;
    std::array<glm::vec3, together> off;
    for (std::size_t begin = 0; begin < places.size(); begin += together) {
        const std::size_t count = std::min(together, places.size() - begin);
        SamplePlaces around;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec3& place = places[begin + i];
            const bool fine = brickAt(sampleAt(place)) != GridBricks::none;
            off[i] = fine ? glm::vec3(1.0F) : 1.0F / grids_.coarseScale;
            for (int axis = 0; axis < 3; ++axis) {
                glm::vec3 along(0.0F);
                along[axis] = off[i][axis];
                around.add(place + along);
                around.add(place - along);
            }
        }
        codes(around, found);
        for (std::size_t i = 0; i < count; ++i) {
            const float* side = found.data() + sides * i;
            for (int axis = 0; axis < 3; ++axis, side += 2)
                slopes[begin + i][axis] = (side[0] - side[1]) / (2.0F * off[i][axis]);
        }
    }
}

}  // namespace mote::render
