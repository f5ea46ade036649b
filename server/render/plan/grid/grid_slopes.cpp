// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "server/render/plan/grid/volume_samples.h"
#include "server/render/plan/seen_fields.h"

namespace mote::render {
namespace {

constexpr std::size_t moreSlopes = 4;
constexpr double slopeLength = 1.0 / 64.0;  // of the longest edge, within which values change

/// The standard deviation of the coarse grid's codes.
double deviationOf(const SampleGrid& grid) {
    const auto end = grid.values.begin() + static_cast<std::ptrdiff_t>(grid.index({0, 0, grid.size.z}));
    const double count = std::max(static_cast<double>(end - grid.values.begin()), 1.0);
    double sum = 0.0, squares = 0.0;
    std::for_each(grid.values.begin(), end, [&](double code) {
        sum += code;
        squares += code * code;
    });
    return std::sqrt(std::max(squares / count - sum / count * (sum / count), 0.0));
}

class Steepness {
  public:
    explicit Steepness(const GridField& field)
        : toLayer_(glm::transpose(glm::inverse(glm::dmat3(field.boxToLayer)))) {
        const double deviation = deviationOf(field.coarse);
        full_ = deviation > 0.0 ? field.longestEdge() * slopeLength / deviation : 0.0;
    }
    /// `slope`: of codes, over the box's edges.
    std::uint8_t operator()(const glm::dvec3& slope) const {
        const double steep = std::clamp(full_ * glm::length(toLayer_ * slope), 0.0, 1.0);
        return static_cast<std::uint8_t>(std::lround(255.0 * steep));
    }

  private:
    glm::dmat3 toLayer_;
    double full_;
};

std::vector<std::uint8_t> coarseSlopes(const SampleGrid& grid, const Steepness& steepness) {
    const glm::uvec3 last = grid.size - 1U;
    std::vector<std::uint8_t> made(grid.index({0, 0, grid.size.z}) + moreSlopes, 0);
    tbb::parallel_for(0U, grid.size.z, [&](std::uint32_t z) {
        for (std::uint32_t y = 0; y < grid.size.y; ++y) {
            for (std::uint32_t x = 0; x < grid.size.x; ++x) {
                const glm::uvec3 at(x, y, z);
                glm::dvec3 slope(0.0);
                for (int axis = 0; axis < 3; ++axis) {
                    glm::uvec3 before = at, behind = at;
                    before[axis] -= at[axis] > 0 ? 1 : 0;
                    behind[axis] += at[axis] < last[axis] ? 1 : 0;
                    slope[axis] =
                        0.5 * grid.size[axis] *
                        (int{grid.values[grid.index(behind)]} - int{grid.values[grid.index(before)]});
                }
                made[grid.index(at)] = steepness(slope);
            }
        }
    });
    return made;
}

/// Codes of a brick's samples, and of those around them, where its own end and another grid's may begin.
class BrickCodes {
  public:
    BrickCodes(const GridBricks& bricks, std::size_t brick, const VolumeSamples& samples)
        : values_(bricks.values.data() +
                  static_cast<std::size_t>(bricks.numbers[brick]) * GridBricks::volume),
          first_(static_cast<int>(GridBricks::edge) * glm::ivec3(brick % bricks.count.x,
                                                                 brick / bricks.count.x % bricks.count.y,
                                                                 brick / bricks.count.x / bricks.count.y)),
          samples_(samples) {}

    /// Of the whole grid, its first sample.
    const glm::ivec3& first() const { return first_; }
    /// `at`: of the whole grid; may lie one beyond it.
    double operator()(const glm::ivec3& at) const {
        constexpr std::uint32_t side = GridBricks::samples;
        const glm::uvec3 inside(at - first_);
        // Its outermost ones belong to the bricks behind it.
        if (inside.x < GridBricks::edge && inside.y < GridBricks::edge && inside.z < GridBricks::edge)
            return values_[(inside.z * side + inside.y) * side + inside.x];
        return samples_.code(glm::vec3(at) + 0.5F);
    }

  private:
    const std::uint16_t* values_;
    glm::ivec3 first_;
    const VolumeSamples& samples_;
};

/// Of each of a brick's samples, also of those that it shares with the next ones.
void addBrick(const GridBricks& bricks, std::size_t brick, const VolumeSamples& samples,
              const Steepness& steepness, std::vector<std::uint8_t>& made) {
    const BrickCodes codes(bricks, brick, samples);
    const glm::ivec3 last(bricks.size - 1U);
    std::size_t to = static_cast<std::size_t>(bricks.numbers[brick]) * GridBricks::volume;
    for (std::uint32_t i = 0; i < GridBricks::volume; ++i) {
        constexpr std::uint32_t side = GridBricks::samples;
        const glm::ivec3 at =
            glm::min(codes.first() + glm::ivec3(i % side, i / side % side, i / side / side), last);
        glm::dvec3 slope(0.0);
        for (int axis = 0; axis < 3; ++axis) {
            glm::ivec3 step(0);
            step[axis] = 1;
            slope[axis] = 0.5 * bricks.size[axis] * (codes(at + step) - codes(at - step));
        }
        made[to++] = steepness(slope);
    }
}

}  // namespace

std::uint64_t gridSlopesBytes(const GridField& field, bool corrected) {
    const std::uint64_t coarse = field.coarse.index({0, 0, field.coarse.size.z}) + moreSlopes;
    if (!corrected || field.bricks == nullptr) return coarse;
    return coarse + field.bricks->corrected() * GridBricks::volume + moreSlopes;
}

GridSlopes gridSlopes(const GridField& field, bool corrected) {
    const Steepness steepness(field);
    GridSlopes slopes{coarseSlopes(field.coarse, steepness), {}};
    if (!corrected || field.bricks == nullptr) return slopes;
    const GridBricks& bricks = *field.bricks;
    const VolumeSamples samples(field);
    slopes.bricks.resize(bricks.corrected() * GridBricks::volume + moreSlopes);
    tbb::parallel_for(std::size_t{0}, bricks.numbers.size(), [&](std::size_t brick) {
        if (bricks.numbers[brick] != GridBricks::none)
            addBrick(bricks, brick, samples, steepness, slopes.bricks);
    });
    return slopes;
}

}  // namespace mote::render
