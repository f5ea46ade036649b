// SPDX-License-Identifier: GPL-3.0-or-later
//
// Calibration measures what points and pixels cost on a device, on a small plot of its own before the first
// view comes. It runs on the device's thread and takes some ten milliseconds on the processor, more on a
// software rasteriser.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/device.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// Pixel work of a quality relative to an exact picture's: samples along the ray, and slabs to composite.
double pixelWork(const Quality& quality);

/// Measures the device. Throws DeviceError.
DeviceCosts calibrate(Device& device);

/// CalibrationStep: a plot in memory that a device is measured with: points spread evenly over all leaves of
/// one octree level, in a volume that is faint everywhere. Immutable.
class CalibrationStep final : public storage::ParticleStep {
  public:
    CalibrationStep();

    storage::OctreeNodes nodes() const override;
    storage::Leaves leaves() const override;
    std::uint64_t pointCount() const override { return positions_.size(); }
    std::span<const storage::PackedPosition> positions(std::uint64_t begin,
                                                       std::uint64_t count) const override;
    std::span<const std::uint64_t> rows(std::uint64_t begin, std::uint64_t count) const override;
    std::span<const float> volume() const override { return volume_; }
    std::uint32_t volumeSize() const override { return volumeEdge; }
    LogDensity logDensity() const override { return {1.0, 1e6}; }

  private:
    static constexpr std::uint8_t level = 4;         // of the leaves
    static constexpr std::uint32_t leafPoints = 32;  // the job's default capacity
    static constexpr std::uint32_t volumeEdge = 64;  // the job's default volume

    void addNodes();
    void addLeaves();

    std::vector<std::uint8_t> level_, childCount_;
    std::vector<std::uint64_t> morton_, count_;
    std::vector<std::uint32_t> firstChild_;
    std::vector<float> density_;
    std::vector<std::uint32_t> leafNode_, leafCount_;
    std::vector<std::uint64_t> leafBegin_;
    std::vector<float> leafDensity_;
    std::vector<storage::PackedPosition> positions_;
    std::vector<std::uint64_t> rows_;
    std::vector<float> volume_;
};

}  // namespace mote::render
