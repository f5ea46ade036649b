// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/hand/steering.h"

#include <array>
#include <cctype>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <string>
#include <utility>

#include "client/view/camera_control.h"
#include "client/view/commands.h"

namespace mote::client {
namespace {

// Of a hand that leans by 1 and does not fly, a second.
constexpr double turnRate = 0.5;   // half turns
constexpr double panRate = 0.6;    // heights of the picture
constexpr double nearRate = 10.0;  // tenths of the way
constexpr double rollRate = 1.5;   // radians

double leaning(float value) {
    const double size = std::abs(static_cast<double>(value));
    if (!(size > deadZone)) return 0.0;
    const double share = std::min((size - deadZone) / (1.0 - deadZone), 1.0);
    return std::copysign(share * share, static_cast<double>(value));
}

double pressed(float trigger) {
    return leaning(0.5F * (trigger + 1.0F));
}

/// Buttons that ask for something, by their places.
constexpr std::array<std::pair<std::size_t, std::string_view>, 6> buttonCommands{{{0, "Fit"},
                                                                                  {1, "Camera before"},
                                                                                  {3, "Fly"},
                                                                                  {4, "Step before"},
                                                                                  {5, "Next step"},
                                                                                  {7, "Play or pause"}}};

}  // namespace

Push& Push::operator+=(const Push& other) {
    const glm::dvec3 one(1.0);
    go = glm::clamp(go + other.go, -one, one);
    turn = glm::clamp(turn + other.turn, -one, one);
    return *this;
}

Push pushOf(const Pad& pad, bool flying) {
    const glm::dvec2 left(leaning(pad.axes[0]), -leaning(pad.axes[1]));
    const glm::dvec2 right(leaning(pad.axes[2]), -leaning(pad.axes[3]));
    const double triggers = pressed(pad.axes[5]) - pressed(pad.axes[4]);
    if (flying) return {{left.x, triggers, left.y}, {right.x, right.y, 0.0}};
    return {{right.x, right.y, triggers}, {left.x, left.y, 0.0}};
}

Push pushOf(const Puck& puck, bool flying) {
    std::array<double, 6> lean{};
    std::ranges::transform(puck.axes, lean.begin(), leaning);
    // The hand holds the eye, or else what is seen.
    const double sign = flying ? -1.0 : 1.0;
    return {{lean[0], -lean[2], sign * lean[1]}, {lean[5], -sign * lean[3], lean[4]}};
}

Push Devices::push(bool flying) const {
    Push all;
    for (const auto& pad : pads) all += pushOf(pad, flying);
    for (const auto& puck : pucks) all += pushOf(puck, flying);
    return all;
}

bool Devices::atRest() const {
    const auto held = [](const Pad& pad) {
        return std::ranges::any_of(pad.buttons, [](bool b) { return b; });
    };
    return push(false).atRest() && std::ranges::none_of(pads, held);
}

std::vector<std::string_view> commandsOf(const Pad& before, const Pad& now) {
    std::vector<std::string_view> commands;
    for (const auto& [button, command] : buttonCommands) {
        if (now.buttons[button] && !before.buttons[button]) commands.push_back(command);
    }
    return commands;
}

bool isPuck(std::string_view name, int axes) {
    const auto lowered = loweredLetters(name);
    return axes == 6 && (lowered.find("3dconnexion") != lowered.npos || lowered.find("space") == 0);
}

Camera flown(const Camera& camera, const Push& push, double way, double angle) {
    const glm::dvec3 ahead = glm::normalize(camera.target - camera.eye);
    const glm::dvec3 right = glm::normalize(glm::cross(ahead, camera.up)), up = glm::cross(right, ahead);
    const glm::dvec3 offset = way * (push.go.x * right + push.go.y * up + push.go.z * ahead);
    Camera moved = camera;
    moved.eye += offset;
    moved.target += offset;
    const glm::dvec2 drag = angle / glm::pi<double>() * glm::dvec2(push.turn.x, -push.turn.y);
    if (drag != glm::dvec2(0.0)) moved = orbit(moved, drag, moved.eye);
    return push.turn.z == 0.0 ? moved : roll(moved, angle * push.turn.z);
}

Camera carried(const Camera& camera, const Push& push, double seconds) {
    Camera moved = camera;
    const glm::dvec2 turn(push.turn.x, -push.turn.y), go(push.go.x, -push.go.y);
    if (turn != glm::dvec2(0.0)) moved = orbit(moved, turnRate * seconds * turn, moved.target);
    if (go != glm::dvec2(0.0)) moved = pan(moved, panRate * seconds * go);
    if (push.go.z != 0.0) moved = dolly(moved, nearRate * seconds * push.go.z, moved.target);
    return push.turn.z == 0.0 ? moved : roll(moved, -rollRate * seconds * push.turn.z);
}

Camera lookedAround(const Camera& camera, glm::dvec2 drag) {
    const double angle = 2.0 * camera.halfHeight();  // that the picture's height is in its middle
    return orbit(camera, -angle / glm::pi<double>() * drag, camera.eye);
}

void FlightSpeed::change(double turns) {
    constexpr double factor = 1.25, least = 0.01, most = 20.0;
    share_ = std::clamp(share_ * std::pow(factor, turns), least, most);
}

}  // namespace mote::client
