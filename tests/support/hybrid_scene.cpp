// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/hybrid_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <stdexcept>

#include "server/render/layers/hybrid/brick_maker.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/hybrid/normal_table.h"

namespace mote::test {
namespace {

using render::GridBricks;
using render::GridField;

template <class Visit>
void forEach(const glm::uvec3& size, const Visit& visit) {
    for (std::uint32_t z = 0; z < size.z; ++z) {
        for (std::uint32_t y = 0; y < size.y; ++y) {
            for (std::uint32_t x = 0; x < size.x; ++x) visit(glm::uvec3(x, y, z));
        }
    }
}

glm::dvec3 placeOf(const glm::uvec3& sample, const glm::uvec3& size) {
    return (glm::dvec3(sample) + 0.5) / glm::dvec3(size);
}

class Maker {
  public:
    Maker(const HybridShape& shape, const std::function<double(const glm::dvec3&)>& field)
        : shape_(shape), field_(field) {}

    /// Towards lower values, in layer space; by differences over a source voxel.
    std::uint8_t normalAt(const glm::dvec3& inBox) const {
        glm::dvec3 slope(0.0);
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 step(0.0);
            step[axis] = 1.0 / shape_.source[axis];
            slope[axis] = (field_(inBox + step) - field_(inBox - step)) / (2.0 * step[axis]);
        }
        return normals_.code(-glm::vec3(glm::transpose(glm::inverse(glm::dmat3(shape_.boxToLayer))) * slope));
    }
    void addLow(GridField& step) const {
        step.coarse.size = shape_.low;
        forEach(shape_.low, [&](const glm::uvec3& at) {
            const glm::dvec3 place = placeOf(at, shape_.low);
            const double code = std::clamp(step.codeOf(field_(place)), 0.0, 65535.0);
            step.coarse.values.push_back(static_cast<std::uint16_t>(std::lround(code)));
            step.coarse.normals.push_back(normalAt(place));
        });
        step.coarse.values.resize(step.coarse.values.size() + 4);
        step.coarse.normals.resize(step.coarse.normals.size() + 4);
    }
    /// The field minus the coarse grid at a sample of the error grid, where that is above the threshold.
    double errorAt(const GridField& step, const glm::uvec3& at) const {
        std::array<storage::Between, 3> along;
        for (int axis = 0; axis < 3; ++axis) {
            along[static_cast<std::size_t>(axis)] = storage::between(
                storage::placeIn(at[axis], shape_.source[axis], shape_.low[axis]), shape_.low[axis]);
        }
        double low = 0.0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            glm::uvec3 sample(0);
            double weight = 1.0;
            for (int axis = 0; axis < 3; ++axis) {
                const auto& between = along[static_cast<std::size_t>(axis)];
                const bool ahead = (corner >> axis & 1U) != 0;
                sample[axis] = ahead ? between.second : between.first;
                weight *= ahead ? double{between.fraction} : 1.0 - double{between.fraction};
            }
            low += weight * step.valueOf(step.coarse.values[step.coarse.index(sample)]);
        }
        const double error = field_(placeOf(at, shape_.source)) - low;
        return std::abs(error) > shape_.threshold ? error : 0.0;
    }
    GridBricks bricksOf(const GridField& step) const {
        render::BrickMaker maker(step, shape_.source);
        if (shape_.parts == HybridRepresentation::points) {
            addPoints(step, maker);
        } else {
            addResidual(step, maker);
        }
        return maker.make();
    }

  private:
    void addResidual(const GridField& step, render::BrickMaker& maker) const {
        const glm::uvec3 count = (shape_.source + (GridBricks::edge - 1)) / GridBricks::edge;
        forEach(count, [&](const glm::uvec3& brick) {
            std::array<float, storage::residualBrickSamples> residual{};
            std::size_t i = 0;
            forEach(glm::uvec3(GridBricks::edge), [&](const glm::uvec3& at) {
                const glm::uvec3 sample = brick * GridBricks::edge + at;
                const bool inside = glm::all(glm::lessThan(sample, shape_.source));
                residual[i++] = inside ? static_cast<float>(errorAt(step, sample)) : 0.0F;
            });
            check(maker.add(brick, residual));
        });
    }
    void addPoints(const GridField& step, render::BrickMaker& maker) const {
        forEach(shape_.source, [&](const glm::uvec3& at) {
            if (errorAt(step, at) == 0.0) return;
            const glm::dvec3 place = placeOf(at, shape_.source);
            const double share = std::clamp(step.codeOf(field_(place)) / 65535.0, 0.0, 1.0);
            check(maker.addPoint(at, static_cast<std::uint16_t>(257 * std::lround(255.0 * share)),
                                 normalAt(place)));
        });
    }
    static void check(const Status& status) {
        if (!status.ok()) throw std::runtime_error("too many bricks");
    }

    const HybridShape& shape_;
    const std::function<double(const glm::dvec3&)>& field_;
    storage::NormalTable normals_;
};

}  // namespace

std::shared_ptr<const GridField> hybridOf(const HybridShape& shape,
                                          const std::function<double(const glm::dvec3&)>& field) {
    auto step = std::make_shared<GridField>();
    step->boxToLayer = shape.boxToLayer;
    step->range = shape.range;
    const Maker maker(shape, field);
    maker.addLow(*step);
    step->parts = shape.parts;
    if (shape.parts != HybridRepresentation::volume)
        step->bricks = std::make_shared<const GridBricks>(maker.bricksOf(*step));
    return step;
}

double machineParts(const glm::dvec3& inBox) {
    const auto within = [](double distance) { return std::clamp(0.5 - 24.0 * distance, 0.0, 1.0); };
    const glm::dvec3 at = inBox - 0.5;
    const double shell = 0.35 * within(std::abs(glm::length(at) - 0.4) - 0.03);
    const double ball = 0.9 * within(glm::length(at - glm::dvec3(0.15, 0.05, 0.1)) - 0.12);
    const double other = 0.6 * within(glm::length(at + glm::dvec3(0.16, 0.1, -0.05)) - 0.09);
    const double rod = within(std::hypot(at.x + 0.05, at.y - 0.12) - 0.02);
    const double ground = 0.1 * (1.0 + at.x);
    return std::max({shell, ball, other, rod, ground});
}

}  // namespace mote::test
