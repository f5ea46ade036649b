// SPDX-License-Identifier: GPL-3.0-or-later
//
// MOTE_CHECK guards our own invariants, in release builds too: a failure is a bug of ours, never of the
// input.
#pragma once

#include <stdexcept>

namespace mote {

/// An invariant of ours does not hold. What was being done is lost; who caught it must not go on with any
/// object that took part in it. Where nobody catches it, the process ends.
class BrokenInvariant : public std::logic_error {
  public:
    using std::logic_error::logic_error;
};

/// Prints the broken invariant and throws BrokenInvariant.
[[noreturn]] void checkFailed(const char* condition, const char* file, int line);

}  // namespace mote

#define MOTE_CHECK(condition) \
    (static_cast<bool>(condition) ? void(0) : ::mote::checkFailed(#condition, __FILE__, __LINE__))
