// SPDX-License-Identifier: GPL-3.0-or-later
//
// What others do, written by us, to compare with: weighted Voronoi stippling (Secord 2002) and weighted
// Linde-Buzo-Gray stippling (Deussen, Spicker and Zheng 2017). Pure functions.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "server/render/layers/stipple/pixel_map.h"

namespace mote::bench {

/// As many dots as the density asks for, at random in proportion to it, then steps of weighted Lloyd.
std::vector<glm::vec2> secord(const render::PixelMap& wanted, int steps, std::uint64_t seed);

/// From the same random dots: cells that hold too much are halved, those that hold too little go, until none
/// does or `steps` are over.
std::vector<glm::vec2> lindeBuzoGray(const render::PixelMap& wanted, int steps, std::uint64_t seed);

}  // namespace mote::bench
