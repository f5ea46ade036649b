// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a selection holds, found slowly: each point is asked by itself, in plain loops that share nothing with
// storage/numbers. Pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/scene/selection.h"
#include "tests/support/memory_run.h"

namespace mote::test {

/// `doubt`: another order of the same arithmetic may say otherwise.
enum class Chosen : std::uint8_t { no, doubt, yes };

/// Of each point of a step.
std::vector<Chosen> plainSelection(const Selection& selection, const MemoryRun& run, std::uint32_t step);

/// A quantity of each point.
std::vector<double> plainQuantity(const std::string& name, const MemoryRun& run, std::uint32_t step);

/// Even-odd, as docs/SELECTIONS.md says it.
bool plainInside(const std::vector<glm::dvec2>& corners, double x, double y);

}  // namespace mote::test
