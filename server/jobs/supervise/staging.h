// SPDX-License-Identifier: GPL-3.0-or-later
//
// Staging: the folder beside an output's place in which a job makes it, and the only one that the job may
// write to. The supervisor makes the folder, and once nothing of the job runs any more gives what lies there
// its place, or throws it away. Move-only; one owner.
#pragma once

#include <filesystem>
#include <string>

#include "protocol/scene/error.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {

class Staging {
  public:
    /// `folder` and `output` are real paths of one parent; what an earlier attempt left there goes. Errors:
    /// permissionDenied, notFound, resourceExhausted, internal.
    static Result<Staging> create(const std::filesystem::path& folder, const std::filesystem::path& output);

    Staging(Staging&&) noexcept = default;
    Staging& operator=(Staging&&) = delete;
    /// Removes the folder and what is left in it.
    ~Staging();

    const std::filesystem::path& folder() const { return folder_; }

    /// Gives folder/NAME, which the job has put on the disk, its place, which must be free. Errors: notFound
    /// (the job made nothing), corrupt (it made other things than files and folders of its own),
    /// alreadyExists, resourceExhausted, internal.
    Status publish();

  private:
    Staging(storage::FileDescriptor parent, std::filesystem::path folder, std::filesystem::path output)
        : parent_(std::move(parent)), folder_(std::move(folder)), output_(std::move(output)) {}

    storage::FileDescriptor parent_;  ///< of both, whatever its name is by now; none: moved from
    std::filesystem::path folder_;
    std::filesystem::path output_;
};

}  // namespace mote::server
