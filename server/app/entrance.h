// SPDX-License-Identifier: GPL-3.0-or-later
//
// Entrance: the sockets of a server, a Unix one and TCP where it is asked for, and those who come in by them
// and have not shown a token yet. Owned by the server, on its thread.
#pragma once

#include <asio/io_context.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/wire/tls.h"
#include "server/app/listener.h"
#include "server/app/server.h"
#include "server/app/socket_place.h"
#include "server/session/startups.h"

namespace mote::server {

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
