// SPDX-License-Identifier: GPL-3.0-or-later
//
// Camera: where the eye stands and what it sees, in world space, right-handed. A value; a parsed one is
// valid: eye and target differ, up is not along the line of sight.
//
// A pixel (column i, row j, row 0 on top) of a W x H picture is seen along the ray through its centre,
// x = (2 (i + 1/2) / W - 1) * W/H * h, y = (1 - 2 (j + 1/2) / H) * h on the plane at depth 1 (perspective,
// h = tan(fov/2)) or as an offset from the axis (orthographic, h = half the height). Depth is measured along
// the line of sight, not along the ray.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "protocol/scene/error.h"

namespace mote {

struct Camera {
    glm::dvec3 eye{0.0, 0.0, 4.0};
    glm::dvec3 target{0.0};
    glm::dvec3 up{0.0, 1.0, 0.0};
    double fovYDegrees = 35.0;  ///< full vertical angle, perspective
    std::optional<double>
        orthographicHeight;  ///< world units across the picture's height; absent: perspective

    /// World to eye: x right, y up, -z along the line of sight.
    glm::dmat4 worldToEye() const;
    /// h of the head comment: half the picture's height at depth 1 (perspective) or everywhere
    /// (orthographic).
    double halfHeight() const;
    bool perspective() const { return !orthographicHeight.has_value(); }

    bool operator==(const Camera&) const = default;
};

/// A perspective camera that sees all of `bounds`, as large as may be, from a direction that shows three
/// sides, for a picture of the given aspect (width over height).
Camera fitCamera(const Bounds& bounds, double aspect);

/// Errors: a vector that is not three finite numbers, eye equal to target, up along the line of sight, an
/// angle outside [0.1, 179] degrees, a height that is not positive.
Result<Camera> parseCamera(const proto::Camera& message);

proto::Camera toProto(const Camera& camera);

/// Nothing nearer to the eye than this share of the distance to the camera's target is seen, in every device,
/// in the reference and by a lasso.
inline constexpr double nearShare = 1e-3;

}  // namespace mote
