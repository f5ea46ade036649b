// SPDX-License-Identifier: GPL-3.0-or-later
//
// How dots make tones (docs/STIPPLES.md, "Tones"). Ink is the share of the paper that dots cover. Dots of
// diameter d at a density of rho would cover phi = rho pi d^2 / 4 if none met another; from where they begin
// to, they cover less. Pure functions.
#pragma once

namespace mote::render {

/// phi at which an even distribution covers everything: its largest cells fit into a dot.
inline constexpr double solidCover = 1.8;

/// Ink of dots at a nominal cover phi, 0 to 1, never falling.
double inkOfCover(double phi);
/// The nominal cover that gives an ink of 0 to 1: the inverse; solidCover for 1.
double coverOfInk(double ink);

/// Dots a square pixel of a diameter of `dot` pixels that give an ink.
double densityOfInk(double ink, double dot);

/// The density of points `spacing` pixels apart in the densest even arrangement, the hexagonal one: a square
/// pixel's share of 2 / (sqrt(3) spacing^2).
double densityOfSpacing(double spacing);

}  // namespace mote::render
