// SPDX-License-Identifier: GPL-3.0-or-later
//
// CameraPath: a smooth way of the camera through keyframes (docs/SCRIPTS.md, "Films"). A value; safe on any
// number of threads.
//
// What moves: the target (a spline), the orientation (a spherical spline, always the shorter way), the height
// that the picture spans at the target and the tangent of half the angle of view (splines of their
// logarithms, and with them of the distance). A parallel projection is a lens of the least angle from far
// away for its perspective neighbours; between two of them the eye has a distance of its own.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "protocol/scene/camera.h"
#include "protocol/scene/film/rotation.h"
#include "protocol/scene/film/spline.h"

namespace mote {

class CameraPath {
  public:
    struct Stop {
        double seconds;
        Camera camera;
        bool jumps = false;  ///< the way to the next one is none: the camera stays, then is there
    };

    /// At least two stops, ascending in time.
    explicit CameraPath(std::span<const Stop> stops);

    /// At a share, 0 to 1, of the way from stop number `way` to the next; where that jumps, the stop's own.
    /// Always valid; at the ends the stops' own but for rounding, the length of `up` and, between a
    /// perspective and a parallel projection, how far off the eye is.
    Camera at(std::size_t way, double share) const;
    std::size_t ways() const { return ways_.size(); }

  private:
    struct Way {
        bool jumps;
        Camera first;
        bool fromParallel, toParallel;
        HermiteWay<glm::dvec3> target;
        HermiteWay<double> height;    ///< log of what the picture spans at the target
        HermiteWay<double> lens;      ///< log tan(fov / 2)
        HermiteWay<double> distance;  ///< log; of parallel projections
        RotationWay orientation;
    };
    static Camera cameraOf(const Way& way, double share);

    std::vector<Way> ways_;
};

}  // namespace mote
