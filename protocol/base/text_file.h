// SPDX-License-Identifier: GPL-3.0-or-later
//
// A file as text, of others' making: as much of it as is allowed. Pure, but for the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "protocol/base/error.h"

namespace mote {

/// Errors: notFound, permissionDenied, invalidArgument (a directory), resourceExhausted (more than `limit`
/// bytes).
Result<std::string> readTextFile(const std::filesystem::path& path, std::size_t limit);

}  // namespace mote
