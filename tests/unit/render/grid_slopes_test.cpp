// SPDX-License-Identifier: GPL-3.0-or-later
//
// How steeply a field changes at its samples, against differences of what is drawn there.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "server/render/plan/grid/volume_samples.h"
#include "server/render/plan/seen_fields.h"

namespace mote::render {
namespace {

constexpr std::uint32_t side = GridBricks::samples;

std::vector<std::uint16_t> noise(std::size_t count) {
    std::mt19937 random(7);
    std::vector<std::uint16_t> values(count);
    std::generate(values.begin(), values.end(), [&] { return static_cast<std::uint16_t>(random() % 4000); });
    return values;
}

/// Noise in a grid of 21 x 16 x 16 samples, some bricks of which are not corrected: the last one along x ends
/// in its middle.
GridField noisyField() {
    GridField field;
    field.coarse.size = {5, 4, 4};
    field.coarse.values = noise(5 * 4 * 4 + 4);
    auto bricks = std::make_shared<GridBricks>();
    bricks->size = {21, 16, 16};
    bricks->count = {3, 2, 2};
    bricks->numbers = {0, 1, 2, 3, -1, 4, -1, 5, 6, 7, 8, -1};
    bricks->values = noise(9 * GridBricks::volume + 4);
    for (std::size_t brick = 2; brick < 12; brick += 3) {
        if (bricks->numbers[brick] < 0) continue;
        const auto number = static_cast<std::size_t>(bricks->numbers[brick]);
        std::uint16_t* const values = bricks->values.data() + number * GridBricks::volume;
        for (std::uint32_t i = 0; i < GridBricks::volume; ++i) {
            const std::uint32_t x = i % side, beyond = x - std::min(x, 20U - 16U);
            values[i] = values[i - beyond];
        }
    }
    field.bricks = std::move(bricks);
    return field;
}

/// Of the coarse grid's samples.
double deviationOf(const GridField& field) {
    double sum = 0.0, squares = 0.0;
    const std::size_t count = field.coarse.values.size() - 4;
    for (std::size_t i = 0; i < count; ++i) {
        sum += field.coarse.values[i];
        squares += double{1} * field.coarse.values[i] * field.coarse.values[i];
    }
    const double mean = sum / static_cast<double>(count);
    return std::sqrt(squares / static_cast<double>(count) - mean * mean);
}

TEST(GridSlopes, AreDifferencesOfWhatIsDrawnBesideASample) {
    const GridField field = noisyField();
    const GridBricks& bricks = *field.bricks;
    const VolumeSamples samples(field);
    const double full = 1.0 / (64.0 * deviationOf(field));
    const GridSlopes slopes = gridSlopes(field, true);
    std::vector<int> least(256);
    for (std::size_t brick = 0; brick < bricks.numbers.size(); ++brick) {
        if (bricks.numbers[brick] == GridBricks::none) continue;
        const glm::uvec3 first = 8U * glm::uvec3(brick % 3, brick / 3 % 2, brick / 6);
        for (std::uint32_t i = 0; i < GridBricks::volume; ++i) {
            const glm::uvec3 at = first + glm::uvec3(i % side, i / side % side, i / side / side);
            const glm::vec3 place = glm::vec3(glm::min(at, bricks.size - 1U)) + 0.5F;
            glm::dvec3 slope(0.0);
            for (int axis = 0; axis < 3; ++axis) {
                glm::vec3 step(0.0F);
                step[axis] = 1.0F;
                slope[axis] = 0.5 * bricks.size[axis] *
                              (double{samples.code(place + step)} - double{samples.code(place - step)});
            }
            const auto expected = std::lround(255.0 * std::clamp(full * glm::length(slope), 0.0, 1.0));
            const auto number = static_cast<std::size_t>(bricks.numbers[brick]);
            const auto found = slopes.bricks[number * GridBricks::volume + i];
            EXPECT_EQ(found, expected) << brick << ": " << at.x << ' ' << at.y << ' ' << at.z;
            ++least[found];
        }
    }
    EXPECT_LT(*std::max_element(least.begin(), least.end()), 3000) << "not all are as steep as any";
}

}  // namespace
}  // namespace mote::render
