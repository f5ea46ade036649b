// SPDX-License-Identifier: GPL-3.0-or-later
//
// Opening and reading the files of a dataset: regular files only, no links, no more than expected. Any
// thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "protocol/scene/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::storage {

/// Errors: notFound, permissionDenied, corrupt (a link, folder or device in a file's place).
Result<FileDescriptor> openRegular(const std::filesystem::path& path);

/// The whole file. Errors: as openRegular, resourceExhausted (larger than `limit`), internal.
Result<std::string> readWhole(const std::filesystem::path& path, std::size_t limit);

}  // namespace mote::storage
