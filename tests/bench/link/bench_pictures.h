// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures as a hand that orbits a beam sees them: what encoders and links are measured with. Pure, but for
// the device that it makes and drops.
#pragma once

#include <string>
#include <vector>

#include "server/render/plan/picture.h"

namespace mote::bench {

struct Orbit {
    std::string name;
    std::vector<render::Picture> pictures;  ///< srgb8, one after the other
};

/// Points alone, the volume alone, both; `count` exact pictures each, a thirtieth of a second of a calm orbit
/// (1 degree) apart. Throws render::DeviceError.
std::vector<Orbit> orbits(std::uint32_t width, std::uint32_t height, int count);

}  // namespace mote::bench
