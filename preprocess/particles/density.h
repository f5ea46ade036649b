// SPDX-License-Identifier: GPL-3.0-or-later
//
// The density volume of a step from the weights in its cells. A pure function.
//
// The manifest's densities: the least and the greatest of a leaf in any step, and each step's particles by
// the scaled log density of their leaf.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/range_builder.h"
#include "protocol/scene/log_density.h"

namespace mote::prep {

/// Adds the weights of cells at `cellLevel`, at least `level`, to those of their cells at `level`, by Morton
/// key.
void addCells(std::span<const CellSum> cells, unsigned cellLevel, unsigned level, std::vector<double>& sums);

/// The densities of the 8^level cells of an octree level, x fastest: weight over the cell's share of the box.
std::vector<float> densityVolume(const std::vector<double>& sums, unsigned level);

/// The range of leaves in ascending density, but for those of zero (macro-particles may weigh nothing); empty
/// where there is no other.
Range densityRange(std::span<const float> density);

/// Adds particles to even bins of t over [0, 1], of which the last holds t = 1. `particles` are as many as
/// the leaves' densities; `bins` are resized to as many as the manifest has.
void addToHistogram(std::span<const float> density, std::span<const std::uint32_t> particles,
                    const LogDensity& scale, std::vector<std::uint64_t>& bins);

}  // namespace mote::prep
