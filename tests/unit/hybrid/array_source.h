// SPDX-License-Identifier: GPL-3.0-or-later
//
// ArraySource: a volume in memory as a source of the job; and the job on it. For tests.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/hybrid/volume_job.h"
#include "preprocess/volume/volume_source.h"
#include "storage/hybrid/hybrid_limits.h"
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

}  // namespace mote::test
