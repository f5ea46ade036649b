// SPDX-License-Identifier: GPL-3.0-or-later
//
// The scenes on which devices are compared with the reference. Made anew at each call; the same on every
// machine.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "server/render/layers/scene.h"
#include "tests/golden/comparison.h"

namespace mote::test {

struct GoldenScene {
    std::string name;                ///< letters and digits
    double coveredShare;             ///< least share of the picture's pixels that differ from the background
    double volumeShare;              ///< least share that the volume changes; 0: the scene is without
    double pointsShare;              ///< least share that the points change; 0: the scene is without
    Limits limits = {};              ///< where stricter or, with a reason, laxer than usual
    double dotsShare = 0.0;          ///< least share that the dots change; 0: the scene is without
    double referenceSamples = 16.0;  ///< volume samples a cell at which the reference has converged
    double meshShare = 0.0;          ///< least share that the mesh changes; 0: the scene is without
    friend std::ostream& operator<<(std::ostream& out, const GoldenScene& scene) { return out << scene.name; }
};

/// All of them, without their data.
const std::vector<GoldenScene>& goldenScenes();

/// Those of hybrid volumes: each representation, each shape of points.
const std::vector<GoldenScene>& goldenHybrids();

/// By a column, highlighted, followed.
const std::vector<GoldenScene>& goldenColors();

/// The data and the view of one.
render::Scene makeScene(const std::string& name);

}  // namespace mote::test
