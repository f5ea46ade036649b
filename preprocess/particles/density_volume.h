// SPDX-License-Identifier: GPL-3.0-or-later
//
// The density volume of a step from the weights in its cells. A pure function.
#pragma once

#include <vector>

#include "preprocess/particles/range_builder.h"

namespace mote::prep {

/// Adds the weights of cells at `cellLevel`, at least `level`, to those of their cells at `level`, by Morton
/// key.
void addCells(std::span<const CellSum> cells, unsigned cellLevel, unsigned level, std::vector<double>& sums);

/// The densities of the 8^level cells of an octree level, x fastest: weight over the cell's share of the box.
std::vector<float> densityVolume(const std::vector<double>& sums, unsigned level);

}  // namespace mote::prep
