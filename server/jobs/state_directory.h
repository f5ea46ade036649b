// SPDX-License-Identifier: GPL-3.0-or-later
//
// StateDirectory: what a server keeps for itself alone: names of programs that it runs, of folders that it
// removes. Files that somebody else made, or may write to, are not taken for its own. Move-only; one server
// has it at a time.
#pragma once

#include <filesystem>
#include <string>

#include "protocol/base/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {

/// Makes the folder (0700), or takes one that is there: of this user, no link, for nobody else to write to.
/// Errors: permissionDenied, saying what is wrong with it.
Status makeOwnFolder(const std::filesystem::path& folder);

/// One that is there, likewise.
Status checkOwnFolder(const std::filesystem::path& folder);

/// A file that is there must be a regular one, of this user and for nobody else to write to; none is well.
/// Errors: permissionDenied.
Status checkOwnFile(const std::filesystem::path& file);

class StateDirectory {
  public:
    /// Makes it, or takes it and locks it: the ids in its database are names of folders that are removed, so
    /// all of it must be ours. Errors: permissionDenied (it cannot be made, is another user's or open to
    /// others), alreadyExists (another server has it).
    static Result<StateDirectory> open(std::filesystem::path place);

    /// Real.
    const std::filesystem::path& path() const { return path_; }
    /// Of all jobs; each has a folder of its id there.
    std::filesystem::path jobs() const { return path_ / "jobs"; }
    std::filesystem::path database() const { return path_ / "jobs.sqlite"; }

  private:
    StateDirectory() = default;

    std::filesystem::path path_;
    storage::FileDescriptor lock_;  // held: no other server has this directory
};

}  // namespace mote::server
