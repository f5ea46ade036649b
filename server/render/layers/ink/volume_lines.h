// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines of what has no edges: where a scalar field ends for the eye, or lies in front of something else
// (docs/INK.md, "Volumes and particles"). Pure; one thread.
#pragma once

#include <stop_token>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/layers/ink/volume_modalities.h"

namespace mote::render {

/// Silhouettes, between rays that are told apart by their opacities or depths. In the order of rows.
std::vector<InkLine> linesOf(const VolumeModalities& seen, const std::stop_token& stop);

}  // namespace mote::render
