// SPDX-License-Identifier: GPL-3.0-or-later
//
// Small files that hold a secret: only their owner may read them. Any thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "protocol/base/error.h"

namespace mote::wire {

/// Appears by one rename, mode 0600. Errors: notFound, permissionDenied, internal (the folder, the disk).
Status writePrivateFile(const std::filesystem::path& path, const std::string& text);

/// Errors: notFound; permissionDenied (not ours, or others may read it too); invalidArgument (no plain file,
/// or more than so many bytes).
Result<std::string> readPrivateFile(const std::filesystem::path& path,
                                    std::size_t mostBytes = std::size_t{64} << 10);

}  // namespace mote::wire
