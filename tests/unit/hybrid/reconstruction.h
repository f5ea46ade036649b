// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a reader makes of a hybrid dataset, by plain loops in double precision that share nothing with the
// job: the low-resolution volume at any place, and the residuals. For tests.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/mote.pb.h"
#include "storage/hybrid/hybrid_file.h"

namespace mote::test {

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

}  // namespace mote::test
