// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the parts of the panel are made of. Main thread, within the panel's window.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "client/view/light_angles.h"
#include "client/view/panel.h"

namespace mote::client {

void text(const std::string& line);
/// In faint letters, wrapped.
void dim(const std::string& line);

/// A number of things with a metric prefix and three digits: "1.23 M points", "512 B/s".
std::string metric(double value, const char* unit);

/// Notes that the last widget changed the view, and whether it is still held.
void note(PanelActions& actions, bool changed);

/// A list of names; true where another one was chosen.
bool chooseName(const char* label, std::string& chosen, std::span<const std::string_view> names);

/// Two sliders, "NAME across" and "NAME above".
void angleSliders(const char* name, LightAngles& angles, PanelActions& actions);

}  // namespace mote::client
