// SPDX-License-Identifier: GPL-3.0-or-later
//
// How even points on the periodic unit square are: the measures of docs/STIPPLES.md. Cells are found by
// clipping with bisectors, with nothing of what the hierarchies are built with. Pure functions.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

namespace mote::test {

struct PlaneMeasures {
    double rho = 0.0;        ///< least distance of two points over that of the hexagonal lattice
    double nearest = 0.0;    ///< mean distance to the nearest point over that of the hexagonal lattice
    double energy = 0.0;     ///< second moments of the cells over those of the hexagonal lattice's
    double areaCv = 0.0;     ///< deviation of the cells' areas over their mean
    double lowEnergy = 0.0;  ///< mean of the spectrum over 0 < |f| < sqrt(N) / 2; white noise: 1
};

struct VoronoiCell {
    double area = 0.0;
    glm::dvec2 centroid{0.0};   ///< minus the point's position
    double secondMoment = 0.0;  ///< integral of the squared distance to the point
    double nearest = 0.0;       ///< distance of the nearest point
};

/// At least one point; anywhere, they are wrapped.
std::vector<VoronoiCell> voronoiCells(const std::vector<glm::dvec2>& points);

PlaneMeasures measurePlane(const std::vector<glm::dvec2>& points);

/// |sum exp(-2 pi i f.x)|^2 / N for integer f of [-reach, reach]^2, rows of ascending f.x within f.y.
std::vector<double> spectrum(const std::vector<glm::dvec2>& points, int reach);

}  // namespace mote::test
