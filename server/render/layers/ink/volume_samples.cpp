// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/volume_samples.h"

#include <glm/common.hpp>

namespace mote::render {
namespace {

/// How far apart in memory the neighbours of a sample lie.
struct Strides {
    std::size_t row, sheet;
};

float mix(float from, float to, float share) {
    return from + share * (to - from);
}

/// Between the eight samples around a place that lies among them.
float interpolated(const std::uint16_t* samples, const glm::vec3& at, const glm::vec3& last,
                   const Strides& strides) {
    const glm::uvec3 below(at);
    const glm::vec3 share = at - glm::vec3(below);
    const std::uint16_t* const first =
        samples + below.z * strides.sheet + below.y * strides.row + std::size_t{below.x};
    const std::size_t x = at.x < last.x ? 1 : 0, y = at.y < last.y ? strides.row : 0,
                      z = at.z < last.z ? strides.sheet : 0;
    const auto along = [&](std::size_t offset) {
        return mix(static_cast<float>(first[offset]), static_cast<float>(first[offset + x]), share.x);
    };
    return mix(mix(along(0), along(y), share.y), mix(along(z), along(z + y), share.y), share.z);
}

}  // namespace

VolumeSamples::VolumeSamples(const GridField& field)
    : field_(field),
      bricks_(field.bricks.get()),
      cells_(bricks_ != nullptr ? bricks_->size : field.coarse.size),
      last_(cells_ - 1.0),
      coarse_(glm::dvec3(field.coarse.size) / cells_),
      coarseLast_(field.coarse.size - 1U) {}

glm::vec3 VolumeSamples::sampleAt(const glm::vec3& place) const {
    return glm::clamp(place - 0.5F, glm::vec3(0.0F), last_);
}

std::int32_t VolumeSamples::brickAt(const glm::vec3& sample) const {
    if (bricks_ == nullptr) return GridBricks::none;
    return bricks_->numbers[bricks_->index(glm::uvec3(sample) / GridBricks::edge)];
}

float VolumeSamples::code(const glm::vec3& place) const {
    const glm::vec3 sample = sampleAt(place);
    const std::int32_t brick = brickAt(sample);
    if (brick == GridBricks::none) {
        const SampleGrid& grid = field_.coarse;
        const glm::vec3 at = glm::clamp(place * coarse_ - 0.5F, glm::vec3(0.0F), coarseLast_);
        return interpolated(grid.values.data(), at, coarseLast_,
                            {grid.size.x, std::size_t{grid.size.x} * grid.size.y});
    }
    constexpr std::size_t row = GridBricks::samples;
    const glm::vec3 corner(glm::uvec3(sample) / GridBricks::edge * GridBricks::edge);
    return interpolated(bricks_->values.data() + static_cast<std::size_t>(brick) * GridBricks::volume,
                        sample - corner, glm::vec3(GridBricks::edge), {row, row * row});
}

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
