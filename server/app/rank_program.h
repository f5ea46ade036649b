// SPDX-License-Identifier: GPL-3.0-or-later
//
// What mote-server does as one of several ranks: the first serves the clients, the others draw for it. Called
// from main, once.
#pragma once

#include <functional>

#include "server/app/server_settings.h"
#include "server/frames/picture_maker.h"
#include "server/render/ranks/ranks.h"

namespace mote::server {

/// Serves clients to the end; returns the exit code.
using Serve = std::function<int(const ServerSettings& settings, DeviceFactory device)>;

/// Returns the exit code. Throws what `serve` throws.
int runRank(render::Ranks& ranks, const ServerSettings& settings, const Serve& serve);

}  // namespace mote::server
