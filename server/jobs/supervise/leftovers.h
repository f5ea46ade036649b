// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a job leaves running: processes whose parents have gone belong to the supervisor, whatever session or
// group they gave themselves. Functions without state, of the supervisor's one thread.
#pragma once

namespace mote::server {

/// From now on what its children leave behind becomes this process's own.
void adoptLeftovers();

/// Kills this process's children, and theirs as they come, until there are none.
void killLeftovers();

}  // namespace mote::server
