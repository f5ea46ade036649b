// SPDX-License-Identifier: GPL-3.0-or-later
//
// BenchScene: what the benches draw: a beam whose every particle is drawn, a ball of 256^3 cells, or both at
// once, or what a view that says nothing shows of them, from eyes on an orbit. Values; pure functions, but
// for the dataset that is read.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "server/render/layers/scene.h"

namespace mote::bench {

enum class Shown { points, volume, hybrid, unsaid };

struct SceneOptions {
    Shown shown = Shown::points;
    /// "beam:PARTICLES" or "ball:LEVEL", made here, or the folder of a dataset, of which the first step.
    std::string data = "beam:1000000";
    std::uint32_t width = 1280;  ///< pixels
    std::uint32_t height = 720;
    double opacity = 0.9999;  ///< of a point
    double pointSize = 1.0;   ///< pixels
    std::string colorBy;   ///< "mean" or "nearest": of a pixel's points by a value of each; empty: one colour
    bool filling = false;  ///< from so near that the data fill the window
};

/// Errors: what is wrong with `data`.
Result<render::Scene> makeScene(const SceneOptions& options);

/// `count` eyes around the camera's target, ten degrees apart, about its upward direction: the first is the
/// camera's own.
std::vector<glm::dvec3> orbitOf(const Camera& camera, int count);

}  // namespace mote::bench
