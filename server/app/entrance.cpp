// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/entrance.h"

#include <utility>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "server/app/identity_file.h"
#include "server/session/outbox.h"

namespace mote::server {
namespace {

/// There is no descriptor for it.
void turnAway(wire::MessageStream stream) {
    stream.turnAway(failureMessage(
        0, {ErrorCode::resourceExhausted, "server", "it has no descriptor left; try again later"}, true));
}

wire::MessageStream plain(Listener::Socket socket) {
    return wire::MessageStream(std::move(socket));
}

}  // namespace

template <class Streams>
Listener::Events Entrance::events(Streams stream) {
    return {.accepted = [this, stream](Listener::Socket socket) { startups_.add(stream(std::move(socket))); },
            .refused = [stream](Listener::Socket socket) { turnAway(stream(std::move(socket))); },
            .crowded = [this] { return startups_.crowded(); }};
}

// TCP is never offered without TLS.
Entrance::Entrance(asio::io_context& io, const ServerSettings& settings, HandshakeTerms terms,
                   Metrics& metrics)
    : settings_(settings),
      startups_(settings.startups, settings.random, settings.failureDelay, std::move(terms), metrics),
      unix_(io, events(plain)),
      tcp_(io, events([this](Listener::Socket socket) {
               return wire::MessageStream(wire::tlsServerStream(std::move(socket), *identity_));
           })) {}

Status Entrance::open(const std::string& token) {
    MOTE_ASSIGN_OR_RETURN(auto place, SocketPlace::make(settings_.stateDirectory));
    place_.emplace(std::move(place));
    MOTE_RETURN_IF_ERROR(unix_.listen(wire::Address::unixAt(place_->path().string())));
    if (!settings_.tcp) return success();
    MOTE_ASSIGN_OR_RETURN(auto identity, readIdentity(settings_.stateDirectory));
    identity_.emplace(std::move(identity));
    const auto known = tcp_.listen(portOfBefore(token));
    return known.ok() ? known : tcp_.listen(*settings_.tcp);
}

wire::Address Entrance::portOfBefore(const std::string& token) const {
    wire::Address wanted = *settings_.tcp;
    const auto old = wire::readConnectionFile(settings_.connectionFile);
    if (wanted.port != 0 || !old.ok() || old->token() != token) return wanted;
    const auto before = wire::parseAddress(old->address());
    if (before.ok()) wanted.port = before->port;
    return wanted;
}

void Entrance::accept() {
    unix_.accept();
    if (identity_) tcp_.accept();
}

void Entrance::close() {
    unix_.close();
    tcp_.close();
    startups_.stop();
}

void Entrance::tellClients(proto::ConnectionFile& file) const {
    if (!identity_) return tellFilms(file);
    file.set_address(tcp_.address().toString());
    file.set_certificate_fingerprint(identity_->fingerprint());
}

void Entrance::tellFilms(proto::ConnectionFile& file) const {
    file.set_address(unix_.address().toString());
}

}  // namespace mote::server
