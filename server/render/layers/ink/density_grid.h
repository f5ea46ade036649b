// SPDX-License-Identifier: GPL-3.0-or-later
//
// The density of particles as a smooth grid: what an ink layer sees of a plot (docs/INK.md, "Volumes and
// particles"). Pure; works in parallel.
#pragma once

#include <cstdint>
#include <memory>

#include "server/render/plan/grid_field.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// Samples that a grid has at most along each axis.
inline constexpr std::uint32_t mostDensities = 128;

/// Weight over a sample's share of the box, of at most mostDensities^3 samples, x fastest: the step's own,
/// or means of theirs, as they were counted.
struct DensitySamples {
    std::uint32_t size = 0;
    std::vector<float> values;
};
DensitySamples densitySamples(const storage::ParticleStep& step);

/// Where few particles lie, means over as many cells as hold enough of them. `particles`: that all values
/// stand for. (After Silverman 1986, Density Estimation for Statistics and Data Analysis, section 5.3:
/// kernels that adapt to the density.)
DensitySamples smoothed(const DensitySamples& samples, double particles);

/// Scaled log densities (protocol/scene/log_density.h) of a step, smoothed; nothing but a plot's box of
/// nothing if it has no particles. Throws storage::StorageError if the volume is damaged.
std::shared_ptr<const GridField> densityGrid(const storage::ParticleStep& step);

/// An estimate of what densityGrid() holds while it works, beside the step's volume.
std::uint64_t densityGridBytes();

}  // namespace mote::render
