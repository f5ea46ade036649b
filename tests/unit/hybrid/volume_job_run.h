// SPDX-License-Identifier: GPL-3.0-or-later
//
// What tests of the volume job share: a volume with edges and noise, the job run to its end, and the
// reconstruction held against the source.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <vector>

#include "storage/verify.h"
#include "tests/unit/hybrid/array_source.h"
#include "tests/unit/hybrid/reconstruction.h"

namespace mote::test {

/// Whole numbers with smooth parts, edges and noise, in every octant another.
inline Volume sample(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz,
                     prep::ScalarType type = prep::ScalarType::u8) {
    std::mt19937 random(7);
    return makeVolume(nx, ny, nz, type, [&](double x, double y, double z) {
        const double wave = 60.0 * (1.0 + std::sin(0.21 * x) * std::cos(0.17 * y + 0.13 * z));
        const double ball = std::hypot(x - nx / 2.0, y - ny / 2.0, z - nz / 2.0) < nx / 4.0 ? 90.0 : 0.0;
        return std::floor(wave + ball + static_cast<double>(random() % 8));
    });
}

inline proto::VolumeJob jobOf(double threshold, std::uint32_t low, const char* representation) {
    proto::VolumeJob job;
    job.set_threshold(threshold);
    job.set_low(low);
    job.set_representation(representation);
    return job;
}

inline void make(const std::vector<Volume>& volumes, const proto::VolumeJob& job,
                 const std::filesystem::path& output, const prep::JobResources& options = {}) {
    QuietProgress progress;
    const auto made = runOn(volumes, job, output, progress, options);
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_TRUE(std::is_sorted(progress.fractions.begin(), progress.fractions.end()));
    EXPECT_EQ(progress.fractions.back(), 1.0);
    const auto errors = storage::verifyDataset(output);
    EXPECT_TRUE(errors.empty()) << errors.front().toString();
}

template <class Visit>
void eachSample(const storage::GridSize& grid, const Visit& visit) {
    for (std::uint32_t z = 0; z < grid[2]; ++z) {
        for (std::uint32_t y = 0; y < grid[1]; ++y) {
            for (std::uint32_t x = 0; x < grid[0]; ++x) visit(storage::GridSize{x, y, z});
        }
    }
}

/// Of float arithmetic in the job: values and interpolated values to some 2^-22 of their size each.
inline double slack(const Volume& volume) {
    double greatest = 0.0;
    for (const float value : volume.values) {
        if (std::isfinite(value)) greatest = std::max(greatest, std::abs(static_cast<double>(value)));
    }
    return 1e-6 * greatest;
}

/// At every sample of the source, the low-resolution volume and the residual are within `most` of it.
inline void expectWithin(const Volume& volume, const Reconstruction& made, double most) {
    const storage::GridSize grid{volume.shape.nx, volume.shape.ny, volume.shape.nz};
    double worst = 0.0;
    eachSample(grid, [&](const storage::GridSize& at) {
        const double value = made.low(at, grid) + made.residual(at);
        worst = std::max(worst, std::abs(value - volume.at(at[0], at[1], at[2])));
    });
    EXPECT_LE(worst, most + slack(volume));
}

}  // namespace mote::test
