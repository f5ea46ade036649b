// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/complain.h"

#include <fmt/format.h>

#include <cstdio>

#include "protocol/scene/utf8.h"

namespace mote {

void complain(std::string_view program, std::string_view sentence) {
    fmt::print(stderr, "{}: {}\n", program, toTerminalText(sentence));
}

}  // namespace mote
