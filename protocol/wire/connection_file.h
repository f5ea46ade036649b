// SPDX-License-Identifier: GPL-3.0-or-later
//
// The connection file: how a client finds its server and proves that it may use it. It holds the token, so
// only its owner may read it. JSON of proto::ConnectionFile. Any thread.
#pragma once

#include <filesystem>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::wire {

/// Appears by one rename, mode 0600. Errors: notFound, permissionDenied, internal (the folder, the disk).
Status writeConnectionFile(const std::filesystem::path& path, const proto::ConnectionFile& content);

/// Errors: notFound; permissionDenied (not ours to read, or others may read it too); invalidArgument (no
/// JSON, an unknown field, an address or token that is none); unsupported (another major version).
Result<proto::ConnectionFile> readConnectionFile(const std::filesystem::path& path);

}  // namespace mote::wire
