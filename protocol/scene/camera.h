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

#include <array>
#include <cmath>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/clip.h"

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

/// From where something is looked at where nobody says it: by default a direction that shows three sides.
struct Outlook {
    glm::dvec3 back{0.45, 0.35, 1.0};  ///< towards the eye, of any length
    glm::dvec3 up{0.0, 1.0, 0.0};      ///< not along `back`

    bool operator==(const Outlook&) const = default;
};

/// CameraFit: finds the perspective camera that sees all of what it is told of, as large as may be, from an
/// outlook. The picture's four sides are planes through the eye; of what is seen only the places count that
/// lie farthest out along the four normals, so places may come in any order and number. A value.
class CameraFit {
  public:
    /// Of each of the picture's sides so much stays free, as a share of the whole.
    static constexpr double usualMargin = 0.05;

    /// `aspect`: width over height.
    CameraFit(const Outlook& outlook, double aspect, double margin = usualMargin);

    /// Takes places of a layer's space, from now on, of which it looks for those that `clips` leave.
    void enter(const glm::dmat4& layerToWorld, HalfSpaces clips = {});
    /// Whether it looks for a place.
    bool takes(const glm::dvec3& place) const { return inAll(clips_, place); }
    /// What is not finite does not count.
    void add(const glm::dvec3& place);
    void add(const Bounds& box);
    /// How much farther out a box reaches than anything before along direction i: above 0, places in it may
    /// count.
    static constexpr int directions = 24;
    double reach(int i, const Bounds& box) const;
    double reach(const Bounds& box) const;

    bool empty() const { return !(most_[0] > -std::numeric_limits<double>::infinity()); }
    /// What was added since enter(), in the layer's space; nothing where nothing was.
    std::optional<Bounds> inLayer() const;
    /// Of nothing: the default camera.
    Camera camera() const;

  private:
    double middle(std::size_t side, double tangent, double z) const;

    double tanX_, tanY_;
    glm::dmat3 axes_;  // right, above, back
    glm::dvec3 up_;
    // Of each slope, from the picture's sides to none: left, right, lower and upper side; near and far; then
    // the sides of the layer's box.
    std::array<glm::dvec3, directions> world_, normals_;
    std::array<double, directions> offsets_{}, most_{};
    double unit_ = 0.0;  // the greatest length of 1 of the layers, world
    HalfSpaces clips_;
};

/// The camera of a box, whose middle it looks at: a hand that turns it turns it around that.
Camera fitCamera(const Bounds& bounds, double aspect, const Outlook& outlook = {},
                 double margin = CameraFit::usualMargin);

/// The least distance between an eye and its target at which their places can be told apart.
inline double leastSight(const glm::dvec3& eye) {
    return 1e-9 * (1e-9 + std::sqrt(eye.x * eye.x + eye.y * eye.y + eye.z * eye.z));
}

/// Errors: a vector that is not three finite numbers, eye equal to target, up along the line of sight, an
/// angle outside [0.1, 179] degrees, a height that is not positive.
Result<Camera> parseCamera(const proto::Camera& message);

proto::Camera toProto(const Camera& camera);

/// Nothing nearer to the eye than this share of the distance to the camera's target is seen, in every device,
/// in the reference and by a lasso.
inline constexpr double nearShare = 1e-3;

}  // namespace mote
