// SPDX-License-Identifier: GPL-3.0-or-later
//
// leafMeans: by what the volume of a layer is coloured whose points are coloured by a column
// (docs/PICTURE.md, "Colour by a column"). Pure; uses all threads of the calling arena.
#pragma once

#include "server/render/plan/point_values.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// Of each leaf the mean of its points' values, without those that have none; noValue where none has.
/// `values`: of all points of the step, or of its leaves. Sums are whole numbers: the same on any number of
/// threads. Throws storage::StorageError.
PointValues leafMeans(const storage::ParticleStep& step, const PointValues& values);

}  // namespace mote::render
