// SPDX-License-Identifier: GPL-3.0-or-later
//
// Steering: what held keys, gamepads and 3D mice do to a camera, which is more the longer they are held. Pure
// functions and values; no window.
#pragma once

#include <algorithm>
#include <array>
#include <glm/vec3.hpp>
#include <string_view>
#include <vector>

#include "protocol/scene/camera.h"

namespace mote::client {

/// How far a hand leans, -1 to 1 each. Where it flies, so does the eye; else what is seen does, as by a drag.
struct Push {
    glm::dvec3 go{0.0};    ///< right, up, ahead (not flying: nearer)
    glm::dvec3 turn{0.0};  ///< right, up, and rolling clockwise

    bool atRest() const { return go == glm::dvec3(0.0) && turn == glm::dvec3(0.0); }
    Push& operator+=(const Push& other);
};

/// A gamepad, in the order that GLFW has for all of them.
struct Pad {
    /// Left stick right and down, right stick right and down, -1 to 1; the triggers, -1 where they are not
    /// pressed.
    std::array<float, 6> axes{0.0F, 0.0F, 0.0F, 0.0F, -1.0F, -1.0F};
    /// A, B, X, Y, left and right bumper, back, start, guide, thumbs, up, right, down, left.
    std::array<bool, 15> buttons{};
};

/// A 3D mouse: right, towards the hand, down; then turned about these, -1 to 1.
struct Puck {
    std::array<float, 6> axes{};
};

/// All that are connected, as they are now.
struct Devices {
    std::vector<Pad> pads;
    std::vector<Puck> pucks;

    Push push(bool flying) const;
    /// Nobody touches any.
    bool atRest() const;
};

/// What leans less than this is at rest; beyond, the square of what is more counts.
inline constexpr double deadZone = 0.15;

Push pushOf(const Pad& pad, bool flying);
Push pushOf(const Puck& puck, bool flying);
/// Names of the viewer's commands whose buttons were not down before.
std::vector<std::string_view> commandsOf(const Pad& before, const Pad& now);
/// Whether a joystick of so many axes that is no gamepad is a 3D mouse: by its name, as sticks with a
/// throttle are not at rest in the middle.
bool isPuck(std::string_view name, int axes);

/// The eye goes so far, in world units, and turns by so many radians where a hand leans by 1.
Camera flown(const Camera& camera, const Push& push, double way, double angle);
/// Turned about its target, moved along and brought nearer, as a hand that leans does in so many seconds.
Camera carried(const Camera& camera, const Push& push, double seconds);
/// The sight turned by a drag, in heights of the picture, so that what is seen goes along with it.
Camera lookedAround(const Camera& camera, glm::dvec2 drag);

/// How fast it is flown, in distances to what is ahead a second; turns of the wheel change it.
class FlightSpeed {
  public:
    double share() const { return share_; }
    void change(double turns);

  private:
    double share_ = 0.5;
};

}  // namespace mote::client
