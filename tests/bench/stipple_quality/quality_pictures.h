// SPDX-License-Identifier: GPL-3.0-or-later
//
// Dots and their spectra as pictures, so that what the numbers say can be seen. Pure functions.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "tests/support/image.h"

namespace mote::bench {

/// Black dots on white, antialiased, `diameter` pixels wide; the unit square fills the picture.
test::Image dotPicture(const std::vector<glm::dvec2>& dots, std::uint32_t size, double diameter);

/// The spectrum of dots on the periodic square up to three times the square root of their number, white
/// noise's mean in middle grey, the origin in the middle and left out.
test::Image spectrumPicture(const std::vector<glm::dvec2>& dots);

}  // namespace mote::bench
