// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a runner needs of the system that it is chosen on. A function that looks at files alone; any thread.
#pragma once

#include <string_view>

#include "protocol/scene/error.h"

namespace mote::server {

/// Whether there is such a runner, and its programs are in PATH. `ranks`: of a job. Errors: invalidArgument
/// (there is no such runner), notFound (the first program that is missing).
Status checkRunner(std::string_view runner, unsigned ranks);

}  // namespace mote::server
