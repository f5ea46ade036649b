// SPDX-License-Identifier: GPL-3.0-or-later
//
// Entrance: the sockets of a server, a Unix one and TCP where it is asked for, and those who come in by them
// and have not shown a token yet. Owned by the server, on its thread.
#pragma once

#include <asio/io_context.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/wire/tls.h"
#include "server/app/listener.h"
#include "server/app/server.h"
#include "server/session/startups.h"

namespace mote::server {

/// A server takes no live one's connection file. Waits for half a second at most. Errors: alreadyExists,
/// where the file belongs to a server that accepts connections now.
Status checkNotInUse(const std::filesystem::path& file);

/// The server's own key and certificate, kept in a file, so that its fingerprint stays: makes it where it is
/// not there. Call once the state directory's lock is held. Errors: permissionDenied (not ours, or others may
/// read it), corrupt, internal.
Result<wire::TlsIdentity> readIdentity(const std::filesystem::path& stateDirectory);

/// SocketPlace: where the Unix socket lies. In the state directory, which belongs to one server at a time
/// (its job queue holds the lock), so that a socket found there is a dead server's; in a fresh private folder
/// where the state directory's path is too long for the kernel. Removed with the object.
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

class Entrance {
  public:
    /// `settings` and `metrics` outlive it. Nothing is touched before open().
    Entrance(asio::io_context& io, const ServerSettings& settings, HandshakeTerms terms, Metrics& metrics);

    /// Listens, once the state directory's lock is held. `token`: a server that starts again has it still,
    /// and takes the port that its clients, and tunnels, know. Errors: each naming the socket or file.
    Status open(const std::string& token);
    /// Begins to accept, or goes on. Throws where memory is short.
    void accept();
    void close();
    /// Removes the Unix socket.
    void withdraw() { place_.reset(); }

    std::size_t startups() const { return startups_.pending(); }
    /// Where clients find it: address and fingerprint.
    void tellClients(proto::ConnectionFile& file) const;
    /// Where films find it, which may open no other sockets than Unix ones.
    void tellFilms(proto::ConnectionFile& file) const;

  private:
    template <class Streams>
    Listener::Events events(Streams stream);
    wire::Address portOfBefore(const std::string& token) const;

    const ServerSettings& settings_;
    Startups startups_;
    std::optional<SocketPlace> place_;
    std::optional<wire::TlsIdentity> identity_;  // with TCP
    Listener unix_, tcp_;
};

}  // namespace mote::server
