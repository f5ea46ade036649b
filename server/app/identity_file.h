// SPDX-License-Identifier: GPL-3.0-or-later
//
// The file with the server's own key and certificate, made when TCP is first asked for and kept, so that its
// fingerprint stays. One thread.
#pragma once

#include <filesystem>

#include "protocol/wire/tls.h"

namespace mote::server {

/// Makes it where it is not there. Call once the state directory's lock is held. Errors: permissionDenied
/// (not ours, or others may read it), corrupt, internal.
Result<wire::TlsIdentity> readIdentity(const std::filesystem::path& stateDirectory);

}  // namespace mote::server
