// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/print_line.h"

#include <cstdio>

namespace mote::client {

Status print(const std::string& text) {
    if (std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0) return success();
    return Error{ErrorCode::internal, "stdout", "cannot be written to any more"};
}

}  // namespace mote::client
