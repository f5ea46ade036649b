// SPDX-License-Identifier: GPL-3.0-or-later
//
// Masks: pictures of marked pixels, those that are not 0. Pure; the same on any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>

#include "server/render/ink/raster.h"

namespace mote::render {

/// Connected pixels, by their sides, that are fewer than `least` become as what is around them: marked ones,
/// whose value is 1, and then holes in them. If `stop` is requested meanwhile some stay.
void dropSpecksAndHoles(Raster<std::uint8_t>& mask, std::size_t least, const std::stop_token& stop);

/// Pixels from the middle of each pixel to that of the nearest marked one, 0 of such a one; at most
/// `most`, which is what a pixel without any has (Felzenszwalb and Huttenlocher 2012, Distance Transforms of
/// Sampled Functions). If `stop` is requested meanwhile some are too far.
Raster<float> distanceTo(const Raster<std::uint8_t>& marks, double most, const std::stop_token& stop = {});

}  // namespace mote::render
