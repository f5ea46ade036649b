// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whether a server could keep its things where its settings say, asked without making any of them. Looks at
// the disk; any thread.
#pragma once

#include "protocol/scene/error.h"
#include "server/app/server.h"

namespace mote::server {

/// The state directory, the connection file and the log. Errors: permissionDenied, saying of the first of
/// them that cannot be what is wrong with it.
Status checkPlaces(const ServerSettings& settings);

}  // namespace mote::server
