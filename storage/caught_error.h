// SPDX-License-Identifier: GPL-3.0-or-later
//
// caughtError: what an exception says, as an Error, for those who answer a large request: to load, to draw,
// to count. A pure function, called in a handler.
#pragma once

#include "protocol/base/error.h"

namespace mote::storage {

/// Returns the error of the exception that is being handled: a StorageError's own; `shortage` if memory was
/// too short for what was asked; else an internal one, at shortage's place.
Error caughtError(Error shortage);

}  // namespace mote::storage
