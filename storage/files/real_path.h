// SPDX-License-Identifier: GPL-3.0-or-later
//
// Opening what was found before: a real path has no links in it, so one that is met on the way now was put
// there meanwhile and is not followed. Functions without state, any thread.
#pragma once

#include <filesystem>

#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::storage {

/// Opens an absolute path, no part of which is a link; `flags` as for open(2), O_CLOEXEC besides. Errors:
/// notFound, permissionDenied (also: a part is a link), resourceExhausted, internal.
Result<FileDescriptor> openReal(const std::filesystem::path& path, int flags);

/// The same part by part, for kernels without openat2 (before Linux 5.6).
Result<FileDescriptor> walkReal(const std::filesystem::path& path, int flags);

/// Opens what lies beneath an open folder, by a relative path without "..", no part of which is a link. An
/// invalid one, and errno, if that fails: ELOOP or ENOTDIR if a part is a link.
FileDescriptor openRealAt(int folder, const std::filesystem::path& path, int flags);

/// The same part by part.
FileDescriptor walkRealAt(int folder, const std::filesystem::path& path, int flags);

}  // namespace mote::storage
