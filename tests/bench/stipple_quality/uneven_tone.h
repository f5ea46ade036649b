// SPDX-License-Identifier: GPL-3.0-or-later
//
// Dots where the wanted density varies: how many there are against what is wanted, and how many come too
// close, for our replay and for the dissertation's two. Pure functions.
#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <vector>

#include "server/render/layers/stipple/replay.h"

namespace mote::bench {

/// The wanted share of all points, 0 to 1, anywhere on the periodic square.
using Tone = std::function<double(glm::dvec2)>;

struct NamedTone {
    const char* name;
    Tone tone;
};

/// A gradient, waves, and discs with hard edges.
std::vector<NamedTone> tones();

enum class Rule {
    prefix,  ///< moves in order up to the first whose neighbour is drawn
    mean,    ///< the mean of all positions that undrawn neighbours ask for
    last,    ///< the last of them
};

std::vector<glm::dvec2> drawUneven(const storage::StippleHierarchy& hierarchy,
                                   const render::StippleReplay& replay, const Tone& tone, Rule rule);

/// Drawn over wanted, less one.
double countError(const storage::StippleHierarchy& hierarchy, const std::vector<glm::dvec2>& dots,
                  const Tone& tone);

/// Across dots that touch where all points are drawn: the distance of the hexagonal lattice of all points.
double dotDiameter(std::size_t points);

/// The share of dots with another one closer than 0.75 times what `diameter` says at both.
double closeShare(const std::vector<glm::dvec2>& dots, const std::function<double(glm::dvec2)>& diameter);

}  // namespace mote::bench
