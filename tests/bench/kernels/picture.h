// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the groups of mote-bench measure on, made once each, from seeds. Pure functions; one thread.
#pragma once

#include "server/render/layers/scene.h"
#include "server/render/plan/picture.h"
#include "tests/bench/device/bench_scene.h"

namespace mote::bench {

/// A million particles; 1280 x 720.
render::Scene beamScene(Shown shown);

/// The exact picture of it, sRGB, by the cpu device.
render::Picture pictureOf(Shown shown);

}  // namespace mote::bench
