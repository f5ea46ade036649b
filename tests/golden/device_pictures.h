// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures of devices as tests want them. Each function makes a failure of a device a failure of the test.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "server/render/device.h"
#include "server/render/layers/make_frame_plan.h"
#include "server/render/plan/quality.h"
#include "tests/support/image.h"

namespace mote::test {

/// The names of all devices that this version has.
std::vector<std::string> deviceKinds();

/// Throws DeviceError if it does not work here.
std::unique_ptr<render::Device> deviceOf(const std::string& kind);

/// The 8-bit picture of a scene, not stopped. Throws std::runtime_error where it is stopped nevertheless or
/// is not in the format that was asked for.
Image picture(render::Device& device, const render::Scene& scene, const render::Quality& quality);

/// The mean linear light of a picture's three channels.
double meanLight(const Image& image);

}  // namespace mote::test
