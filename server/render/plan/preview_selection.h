// SPDX-License-Identifier: GPL-3.0-or-later
//
// A PreviewSelection says which points of a step's preview are drawn in place of a small share of all points:
// the same ones, but streamed instead of looked up leaf by leaf. A value; pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "protocol/scene/curve.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

struct PreviewSelection {
    /// Densities are told apart so finely: PreviewPoint::density >> densityShift.
    static constexpr unsigned densityShift = 4;
    static constexpr std::size_t densities = 65536 >> densityShift;

    std::uint64_t points = 0;  ///< from the first
    /// Limits by density: a point is drawn where its block's threshold is below.
    std::array<float, densities> limit{};
};

/// The points of the preview that are drawn where the curve's fraction is multiplied by `share`; nothing
/// where the preview does not reach so far. Throws storage::StorageError.
std::optional<PreviewSelection> selectPreview(const storage::ParticleStep& step, const Curve& pointFraction,
                                              double share);

/// The greatest share, at most `share`, that the first `points` of the preview show; 0 where they show none.
/// Throws storage::StorageError.
double previewShare(const storage::ParticleStep& step, const Curve& pointFraction, double share,
                    std::uint64_t points);

}  // namespace mote::render
