// SPDX-License-Identifier: GPL-3.0-or-later
//
// Role: what a client may do, as its token says.
#pragma once

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::server {

enum class Role {
    owner,     ///< everything
    follower,  ///< look at datasets and follow sessions
};

/// Whether a client may ask for this. Errors: permissionDenied.
Status allowed(Role role, const proto::ClientMessage& message);

}  // namespace mote::server
