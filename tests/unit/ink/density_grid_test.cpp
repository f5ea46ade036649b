// SPDX-License-Identifier: GPL-3.0-or-later
//
// Particles as a smooth field: what is counted is kept, noise is not, and gaps stay empty.
#include "server/render/layers/ink/density_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "storage/storage_error.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"

namespace mote::render {
namespace {

/// Densities are weights over shares of the box: their mean is the weight of all.
double weightOf(const DensitySamples& samples) {
    const double sum = std::accumulate(samples.values.begin(), samples.values.end(), 0.0);
    return sum / static_cast<double>(samples.values.size());
}

TEST(DensityGrid, KeepsTheWeightOfABeam) {
    const auto points = test::beam({.core = 40000, .halo = 4000, .filaments = 2000, .evenWeights = false});
    double weight = 0.0;
    for (const auto& point : points) weight += point.weight;
    const auto step = test::MemoryStep::make(points, {.volumeLevel = 5});
    const auto counted = densitySamples(*step);
    EXPECT_NEAR(weightOf(counted), weight, 1e-5 * weight);
    const auto made = smoothed(counted, static_cast<double>(points.size()));
    EXPECT_EQ(made.size, 32U);
    EXPECT_NEAR(weightOf(made), weight, 1e-4 * weight);
}

TEST(DensityGrid, TakesMeansOfMoreCells) {
    std::vector<float> volume(std::size_t{256} * 256 * 256);
    for (std::size_t i = 0; i < volume.size(); ++i) volume[i] = static_cast<float>(i % 7 + i / 65536 % 3);
    const auto step = test::MemoryStep::make(test::evenCloud(10, 1), {.volumeLevel = 8, .volume = volume});
    const auto counted = densitySamples(*step);
    EXPECT_EQ(counted.size, mostDensities);
    const double mean =
        std::accumulate(volume.begin(), volume.end(), 0.0) / static_cast<double>(volume.size());
    EXPECT_NEAR(weightOf(counted), mean, 1e-4 * mean);
}

/// A tenth of a particle a cell: what was counted is nearly everywhere nothing.
TEST(DensityGrid, IsEvenWhereParticlesAre) {
    constexpr double particles = 3277.0;
    const auto step = test::MemoryStep::make(test::evenCloud(3277, 2), {.volumeLevel = 5});
    const auto counted = densitySamples(*step), made = smoothed(counted, particles);
    const auto spread = [&](const DensitySamples& samples) {
        double squares = 0.0;
        for (const float value : samples.values)
            squares += (static_cast<double>(value) - particles) * (static_cast<double>(value) - particles);
        return std::sqrt(squares / static_cast<double>(samples.values.size())) / particles;
    };
    EXPECT_GT(spread(counted), 2.5);
    // Some 8 to 64 particles in a kernel: a third, to an eighth.
    EXPECT_LT(spread(made), 0.3);
}

TEST(DensityGrid, LeavesGapsEmpty) {
    auto points = test::evenCloud(60000, 3);
    for (auto& point : points) point.position.x *= 0.5;
    const auto step = test::MemoryStep::make(points, {.volumeLevel = 5});
    const auto made = smoothed(densitySamples(*step), 60000.0);
    const auto at = [&](std::uint32_t x) { return made.values[(std::size_t{16} * 32 + 16) * 32 + x]; };
    EXPECT_NEAR(static_cast<double>(at(8)), 120000.0, 60000.0);
    EXPECT_LT(at(20), 3000.0F);
    EXPECT_LT(at(28), 10.0F);
}

TEST(DensityGrid, IsScaledAsThePlotIs) {
    const auto step =
        test::MemoryStep::make(test::beam({.core = 20000, .halo = 2000, .filaments = 0}), {.volumeLevel = 4});
    const auto field = densityGrid(*step);
    EXPECT_EQ(field->coarse.size, glm::uvec3(16));
    EXPECT_GE(field->coarse.values.size(), 4096U + 4U);
    EXPECT_EQ(field->bounds(), plotBounds);
    const auto made = smoothed(densitySamples(*step), 22000.0);
    for (std::size_t i = 0; i < made.values.size(); ++i) {
        const double t = step->logDensity().ofCell(static_cast<double>(made.values[i]));
        EXPECT_NEAR(field->valueOf(field->coarse.values[i]), t, 1e-5);
    }
    EXPECT_EQ(field->coarse.values[0], 0) << "no particles in the corner";
}

TEST(DensityGrid, SurvivesWhatIsNotThere) {
    const auto none = densityGrid(*test::MemoryStep::make({}));
    EXPECT_EQ(*std::max_element(none->coarse.values.begin(), none->coarse.values.end()), 0);
    const auto one = densityGrid(*test::MemoryStep::make({{glm::dvec3(0.5)}}, {.volumeLevel = 0}));
    EXPECT_EQ(one->coarse.size, glm::uvec3(1));
}

}  // namespace
}  // namespace mote::render
