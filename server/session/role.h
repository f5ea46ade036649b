// SPDX-License-Identifier: GPL-3.0-or-later
//
// Role: what a client may do, as its token says.
#pragma once

namespace mote::server {

enum class Role {
    owner,     ///< everything
    follower,  ///< look at datasets and follow sessions
};

}  // namespace mote::server
