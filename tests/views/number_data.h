// SPDX-License-Identifier: GPL-3.0-or-later
//
// Numbers beside the particles of generated views: columns and ids of all steps of a dataset, and what layers
// make of them: selections, highlights, colours, paths. Pure functions of what they are given.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/view.h"
#include "server/render/layers/scene.h"
#include "tests/support/memory_run.h"
#include "tests/support/random.h"

namespace mote::test {

/// Columns x, y, z (where points lie in the box), px (anything, NaN for some) and constant; ids are rows.
MemoryRun::Step withNumbers(std::shared_ptr<const MemoryStep> step);

/// Adds what a layer of particles asks for to its step, as the server does. Errors: of the numbers that it
/// asks for.
Status addNumbers(const Layer& layer, const MemoryRun& run, render::LayerData& data);

/// Gives a layer of particles any of a selection, a highlight, a colour by a column and paths, or none.
void setAnyNumbers(Random& random, std::uint32_t steps, proto::Layer& layer);

}  // namespace mote::test
