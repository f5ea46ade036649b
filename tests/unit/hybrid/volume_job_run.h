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
#include <string>
#include <vector>

#include "preprocess/hybrid/volume_job.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/mote.pb.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/verify.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {

struct Volume {
    prep::VolumeShape shape;
    std::vector<float> values;  ///< x fastest

    float at(std::size_t x, std::size_t y, std::size_t z) const {
        return values[(z * shape.ny + y) * shape.nx + x];
    }
};

/// A volume whose value at each sample is what `function(x, y, z)` says.
template <class Function>
Volume makeVolume(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, prep::ScalarType type,
                  const Function& function) {
    Volume volume;
    volume.shape.nx = nx;
    volume.shape.ny = ny;
    volume.shape.nz = nz;
    volume.shape.type = type;
    for (std::uint32_t z = 0; z < nz; ++z) {
        for (std::uint32_t y = 0; y < ny; ++y) {
            for (std::uint32_t x = 0; x < nx; ++x) {
                volume.values.push_back(static_cast<float>(function(x, y, z)));
            }
        }
    }
    return volume;
}

/// A volume in memory as a source of the job; and the job on it. For tests.
class ArraySource final : public prep::VolumeSource {
  public:
    explicit ArraySource(const Volume& volume) : volume_(volume) {}
    std::string format() const override { return "array"; }
    const prep::VolumeShape& shape() const override { return volume_.shape; }
    bool sequential() const override { return false; }
    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        const auto slice = volume_.shape.voxelsOfSlice();
        MOTE_CHECK(z0 < z1 && z1 <= volume_.shape.nz && values.size() == slice * (z1 - z0));
        std::copy_n(volume_.values.begin() + static_cast<std::ptrdiff_t>(z0 * slice), values.size(),
                    values.begin());
        return success();
    }

  private:
    const Volume& volume_;
};

/// The job on volumes in memory, one a step.
inline Result<proto::Manifest> runOn(const std::vector<Volume>& volumes, const proto::VolumeJob& job,
                                     const std::filesystem::path& output, QuietProgress& progress,
                                     const prep::JobResources& options = {}) {
    proto::JobRequest request;
    *request.mutable_volume() = job;
    std::vector<std::filesystem::path> names;
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        names.push_back(output.parent_path() / std::to_string(i));
        request.mutable_volume()->add_inputs(names.back().string());
    }
    const prep::OpenVolume open = [&](std::size_t i) -> Result<std::unique_ptr<prep::VolumeSource>> {
        return std::unique_ptr<prep::VolumeSource>(std::make_unique<ArraySource>(volumes[i]));
    };
    return prep::runVolumeJob(request, open, names, output, options, progress);
}

// What a reader makes of a hybrid dataset, by plain loops in double precision that share nothing with the
// job: the low-resolution volume at any place, and the residuals. For tests.

class Reconstruction {
  public:
    /// Fails the test where the dataset cannot be read.
    Reconstruction(const std::filesystem::path& dataset, std::uint32_t step);

    const proto::Manifest& manifest() const { return manifest_; }
    const proto::HybridStepEntry& entry() const { return manifest_.hybrid().steps(static_cast<int>(step_)); }
    /// The low-resolution volume, trilinear, at a sample of a grid of this size.
    double low(const storage::GridSize& at, const storage::GridSize& grid) const;
    /// The residual at a sample of the error grid.
    double residual(const storage::GridSize& at) const;
    std::vector<storage::HybridPoint> points() const;
    /// Code of the normal of a sample of the low-resolution volume.
    std::uint8_t normal(const storage::GridSize& at) const;

  private:
    double code(std::int64_t x, std::int64_t y, std::int64_t z) const;

    proto::Manifest manifest_;
    std::uint32_t step_;
    std::optional<storage::HybridStep> file_;
    storage::GridSize low_{}, error_{};
    std::vector<float> residuals_;
};

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
