// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which drawn point of a step is seen nearest to a place of a picture: by way of the octree, whose cells
// farther than what is found already are left at their root. A function without state; one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>

#include "protocol/scene/curve.h"
#include "protocol/scene/view.h"
#include "storage/particles/particle_step.h"

namespace mote::server {

/// A place of a view.
struct PicturePlace {
    double x = 0.0, y = 0.0;  ///< pixels from the picture's left and upper edge
};

struct NearestPoint {
    double distance = std::numeric_limits<double>::infinity();  ///< pixels; infinite: there is none
    double depth = std::numeric_limits<double>::infinity();     ///< along the line of sight
    std::uint64_t point = 0;                                    ///< of the step
    glm::dvec3 position{0.0};                                   ///< layer space
    double density = 0.0;                                       ///< scaled log density of its leaf

    bool before(const NearestPoint& other) const {
        return distance < other.distance || (distance == other.distance && depth < other.depth);
    }
};

/// The nearest that comes before `best`; `best` if there is none. Of two as near, the one nearer to the
/// eye. `fraction`: of a leaf's points that are drawn, by its density. `clips`: what they cut away is not
/// there. False if `cancelled` says to stop. Throws storage::StorageError.
bool findNearest(const storage::ParticleStep& step, const Curve& fraction, const View& view,
                 const glm::dmat4& layerToWorld, const HalfSpaces& clips, const PicturePlace& place,
                 const std::function<bool()>& cancelled, NearestPoint& best);

}  // namespace mote::server
