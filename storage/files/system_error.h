// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the kernel's error numbers are called among our errors. Pure.
#pragma once

#include <string>
#include <string_view>

#include "protocol/scene/error.h"

namespace mote::storage {

/// notFound, permissionDenied, alreadyExists, resourceExhausted or internal; "WHERE: WHAT: No such file ...".
Error systemError(int number, std::string where, std::string_view what);

}  // namespace mote::storage
