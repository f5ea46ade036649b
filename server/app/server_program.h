// SPDX-License-Identifier: GPL-3.0-or-later
//
// serverProgram: all of mote-server but its name: options, one supervised server or one of its ranks, the
// exit code.
#pragma once

#include <functional>
#include <memory>

#include "server/render/device.h"

namespace mote::server {

/// render::createDevice, or a test's. May throw render::DeviceError.
using DeviceMaker = std::function<std::unique_ptr<render::Device>(render::DeviceKind, unsigned threads)>;

/// To be called first and once, before any thread of ours runs. Returns the exit code.
int serverProgram(int argc, const char* const* argv, const DeviceMaker& maker);

}  // namespace mote::server
