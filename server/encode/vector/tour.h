// SPDX-License-Identifier: GPL-3.0-or-later
//
// A short way through dots, for a pen: along a Hilbert curve, then shortened by 2-opt among neighbours on the
// way (Croes 1958), so often and so far only that the time stays proportional to the dots. Pure.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace mote::server {

/// The order in which to visit the places, an open way; through random places less than a fifth longer than
/// the shortest.
std::vector<std::uint32_t> shortTour(std::span<const glm::dvec2> places);

}  // namespace mote::server
