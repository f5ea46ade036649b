// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the kernel's error numbers are called among our errors, and in words. Pure functions.
#pragma once

#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace mote {

/// "No such file or directory".
std::string systemMessage(int number);

/// notFound, permissionDenied, alreadyExists, resourceExhausted or internal; "WHERE: WHAT: No such file ...".
/// Passing where disks, quotas, descriptors or processes are used up.
Error systemError(int number, std::string where, std::string_view what);

/// Of a call that fails by no fault of what it is given, from errno.
Error failedCall(const char* call);

}  // namespace mote
