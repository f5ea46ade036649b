// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/slab_window.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace mote::prep {

Status SlabWindow::cover(std::uint32_t z0, std::uint32_t z1) {
    MOTE_CHECK(z0 >= begin_ && z1 >= end_ && z0 < z1);
    const auto kept = end_ > z0 ? end_ - z0 : 0;
    const auto from = std::max(z0, end_);
    if (kept > 0) {
        std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>((z0 - begin_) * slice_), kept * slice_,
                    values_.begin());
    }
    values_.resize((z1 - z0) * slice_);
    begin_ = z0;
    end_ = z1;
    if (from == z1) return success();
    const auto fresh = std::span(values_).subspan(kept * slice_);
    MOTE_RETURN_IF_ERROR(source_.read(from, z1, fresh));
    if (source_.shape().type != ScalarType::f32 && source_.shape().type != ScalarType::f64) return success();
    tbb::parallel_for(std::size_t{0}, std::size_t{z1 - from}, [&](std::size_t z) {
        for (auto& value : fresh.subspan(z * slice_, slice_)) value = std::isfinite(value) ? value : least_;
    });
    return success();
}

}  // namespace mote::prep
