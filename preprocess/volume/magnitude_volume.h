// SPDX-License-Identifier: GPL-3.0-or-later
//
// MagnitudeVolume: the lengths of vectors whose components are volumes of one shape. One owner, one thread at
// a time.
#pragma once

#include <memory>
#include <vector>

#include "preprocess/volume/volume_source.h"

namespace mote::prep {

class MagnitudeVolume : public VolumeSource {
  public:
    /// One at least.
    explicit MagnitudeVolume(std::vector<std::unique_ptr<VolumeSource>> components);

    std::string format() const override { return components_.front()->format(); }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return components_.front()->sequential(); }
    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override;
    std::vector<std::string> takeNotes() override;

  private:
    std::vector<std::unique_ptr<VolumeSource>> components_;
    VolumeShape shape_;
    std::vector<float> one_;
    std::vector<double> sums_;
};

}  // namespace mote::prep
