// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/magnitude_volume.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "protocol/scene/mote_check.h"

namespace mote::prep {

MagnitudeVolume::MagnitudeVolume(std::vector<std::unique_ptr<VolumeSource>> components)
    : components_(std::move(components)) {
    MOTE_CHECK(!components_.empty());
    shape_ = components_.front()->shape();
    shape_.type = ScalarType::f32;  // lengths of integers are none
    shape_.valueStep = 0.0;
}

/// Slice by slice, so that sums take no more memory than one.
Status MagnitudeVolume::read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) {
    const auto slice = static_cast<std::size_t>(shape_.voxelsOfSlice());
    MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == slice * (z1 - z0));
    one_.resize(slice);
    for (std::uint32_t z = z0; z < z1; ++z) {
        sums_.assign(slice, 0.0);
        for (auto& component : components_) {
            MOTE_RETURN_IF_ERROR(component->read(z, z + 1, one_));
            for (std::size_t i = 0; i < slice; ++i) sums_[i] += static_cast<double>(one_[i]) * one_[i];
        }
        const auto made = values.subspan((z - z0) * slice, slice);
        std::transform(sums_.begin(), sums_.end(), made.begin(),
                       [](double sum) { return static_cast<float>(std::sqrt(sum)); });
    }
    return success();
}

std::vector<std::string> MagnitudeVolume::takeNotes() {
    std::vector<std::string> notes;
    for (auto& component : components_) {
        auto some = component->takeNotes();
        std::move(some.begin(), some.end(), std::back_inserter(notes));
    }
    return notes;
}

}  // namespace mote::prep
