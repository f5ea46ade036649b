// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/complain.h"

#include <fmt/format.h>

#include <cstdio>
#include <new>

#include "protocol/base/utf8.h"

namespace mote {

void complain(std::string_view program, std::string_view sentence) {
    fmt::print(stderr, "{}: {}\n", program, toTerminalText(sentence));
}

void complainAtEnd(const char* program, const std::exception& failure) noexcept {
    try {
        if (dynamic_cast<const std::bad_alloc*>(&failure) == nullptr)
            return complain(program, failure.what());
    } catch (const std::exception&) {
        // There is none for the sentence either.
    }
    std::fprintf(stderr, "%s: there is not enough memory\n", program);
}

}  // namespace mote
