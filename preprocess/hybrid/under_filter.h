// SPDX-License-Identifier: GPL-3.0-or-later
//
// Low-resolution volumes that overestimate no sample of the source by more than an allowance (section 3.2.1.2
// of the dissertation). A function without state; it works on the caller's oneTBB threads.
//
// The dissertation takes minima, which underestimates wide areas. Here each sample x of the source that the
// trilinear interpolation of `low` overshoots by v(x) beyond the allowance asks its (at most eight)
// neighbours i of weight w_i for a fall of v w_i / sum(w_j^2), the least change that takes v away (Kaczmarz's
// projection); each neighbour falls by the greatest that is asked of it. Every x then falls by v(x) at least.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "preprocess/hybrid/slab_window.h"
#include "preprocess/hybrid/value_range.h"
#include "preprocess/hybrid/volume_plan.h"

namespace mote::prep {

/// Lowers `low`, all slices of it, by what the source's slices [z0, z1) ask for; `falls` is as large and
/// holds the greatest falls so far. What several calls for parts of the source found is combined by taking
/// greatest falls. Errors: the source's, cancelled.
Status findFalls(VolumeSource& source, const VolumePlan& plan, const ValueRange& range,
                 std::span<const float> low, std::uint32_t z0, std::uint32_t z1, std::uint32_t together,
                 const std::function<Status(std::uint32_t z)>& progress, std::span<float> falls);

}  // namespace mote::prep
