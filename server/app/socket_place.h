// SPDX-License-Identifier: GPL-3.0-or-later
//
// SocketPlace: the path of the server's Unix socket. Owned by the server; one thread.
#pragma once

#include <filesystem>
#include <utility>

#include "protocol/scene/error.h"

namespace mote::server {

/// Where the Unix socket lies. In the state directory, which belongs to one server at a time (its job queue
/// holds the lock), so that a socket found there is a dead server's; in a fresh private folder where the
/// state directory's path is too long for the kernel. Removed with the object.
class SocketPlace {
  public:
    /// Removes a stale socket. Call once the state directory's lock is held. Errors: alreadyExists (something
    /// that is no socket has its name), invalidArgument (no place has a path that is short enough),
    /// permissionDenied, internal.
    static Result<SocketPlace> make(const std::filesystem::path& stateDirectory);

    SocketPlace(SocketPlace&& other) noexcept
        : path_(std::exchange(other.path_, {})), folder_(std::exchange(other.folder_, {})) {}
    SocketPlace& operator=(SocketPlace&&) = delete;
    ~SocketPlace();

    const std::filesystem::path& path() const { return path_; }

  private:
    SocketPlace(std::filesystem::path path, std::filesystem::path folder)
        : path_(std::move(path)), folder_(std::move(folder)) {}

    std::filesystem::path path_;
    std::filesystem::path folder_;  // of our own, to be removed; or empty
};

}  // namespace mote::server
