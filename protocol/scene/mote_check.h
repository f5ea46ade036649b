// SPDX-License-Identifier: GPL-3.0-or-later
//
// MOTE_CHECK guards our own invariants, in release builds too: a failure is a bug of ours, never of the
// input.
#pragma once

namespace mote {

/// Prints the broken invariant and aborts.
[[noreturn]] void checkFailed(const char* condition, const char* file, int line);

}  // namespace mote

#define MOTE_CHECK(condition) \
    (static_cast<bool>(condition) ? void(0) : ::mote::checkFailed(#condition, __FILE__, __LINE__))
