// SPDX-License-Identifier: GPL-3.0-or-later
//
// Runs a short program of the system, sbatch say, without waiting for it. A function; the io_context's
// thread.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "protocol/scene/error.h"

namespace asio {
class io_context;
}

namespace mote::server {

/// `done` is called once, from the io_context, with what the program (its first word, a path) printed on
/// stdout. It has a minute. Errors: notFound (the program), resourceExhausted (it failed, with what it
/// printed last on stderr, or took too long: the place is to blame).
void runCommand(asio::io_context& context, std::vector<std::string> words,
                std::function<void(Result<std::string>)> done);

}  // namespace mote::server
