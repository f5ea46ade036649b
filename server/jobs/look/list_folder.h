// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies in a folder beneath a root, for who chooses a file of it. It opens no file, follows no link out
// of the root, and reads a bounded number of names. Functions without state; any thread.
#pragma once

#include <cstddef>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/roots.h"

namespace mote::server {

inline constexpr std::size_t mostListed = 10'000;        ///< names in an answer
inline constexpr std::size_t mostFolderNames = 100'000;  ///< names that are read of a folder

/// A page of the folder, or of the roots. Left out are names that begin with a dot, drafts of jobs, names
/// that are not UTF-8, links that lead out of the root, and what is neither a file nor a folder; notes say
/// so, but of the first two. Errors: invalidArgument (its form, a file), notFound, permissionDenied, each
/// with the folder's name.
Result<proto::Folder> listFolder(const proto::ListFolder& wanted, const storage::Roots& roots);

/// Whether a name stands before another, without regard to case and with numbers in them by their value:
/// "run_9" before "run_10".
bool standsBefore(std::string_view one, std::string_view other);

}  // namespace mote::server
