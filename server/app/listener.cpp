// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/listener.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/stat.h>

#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>

#include "server/log.h"

namespace mote::server {
namespace {

using namespace std::chrono_literals;
using Endpoint = wire::ByteStream::Socket::endpoint_type;

/// After an error that is not the client's (no descriptors left, say), accepting again at once would spin.
constexpr auto errorPause = 200ms;
/// In a crowd 500 a second are taken at most.
constexpr auto crowdPause = 2ms;
/// How many are told at once that there is no descriptor for them.
constexpr int refusedAtOnce = 16;

Error cannotListen(const wire::Address& address, const asio::error_code& code) {
    return {ErrorCode::internal, address.toString(), "cannot listen: " + code.message()};
}

/// What is made while it lives has no rights for others.
class PrivateMask {
  public:
    PrivateMask() : before_(::umask(0177)) {}
    ~PrivateMask() { ::umask(before_); }
    PrivateMask(const PrivateMask&) = delete;
    PrivateMask& operator=(const PrivateMask&) = delete;

  private:
    mode_t before_;
};

std::uint16_t portOf(const Endpoint& endpoint) {
    const auto* data = endpoint.data();
    if (data->sa_family == AF_INET) return ntohs(reinterpret_cast<const sockaddr_in*>(data)->sin_port);
    return ntohs(reinterpret_cast<const sockaddr_in6*>(data)->sin6_port);
}

storage::FileDescriptor spareDescriptor() {
    return storage::FileDescriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC));
}

bool isShortOfDescriptors(const asio::error_code& code) {
    return code == asio::error::no_descriptors || code == std::errc::too_many_files_open_in_system;
}

}  // namespace

Result<Endpoint> endpointOf(asio::io_context& io, const wire::Address& address) {
    if (address.kind == wire::Address::Kind::unixSocket)
        return Endpoint(asio::local::stream_protocol::endpoint(address.path));
    asio::error_code code;
    asio::ip::tcp::resolver resolver(io);
    const auto found = resolver.resolve(address.host, std::to_string(address.port), code);
    if (code || found.empty()) {
        return Error{ErrorCode::notFound, address.toString(), "there is no such host: " + code.message()};
    }
    return Endpoint(found.begin()->endpoint());
}

Listener::Listener(asio::io_context& io, Events events)
    : events_(std::move(events)), acceptor_(io), pause_(io), spare_(spareDescriptor()) {}

Status Listener::listen(const wire::Address& address) {
    address_ = address;
    MOTE_ASSIGN_OR_RETURN(
        const auto endpoint,
        endpointOf(static_cast<asio::io_context&>(acceptor_.get_executor().context()), address));
    const bool tcp = address.kind == wire::Address::Kind::tcp;
    asio::error_code code;
    acceptor_.close(code);
    acceptor_.open(endpoint.protocol(), code);
    if (!code && tcp) acceptor_.set_option(asio::socket_base::reuse_address(true), code);
    if (!code) {
        const PrivateMask mask;
        acceptor_.bind(endpoint, code);
    }
    if (!code) acceptor_.listen(asio::socket_base::max_listen_connections, code);
    if (!code) acceptor_.non_blocking(true, code);
    const auto bound = code ? Endpoint() : acceptor_.local_endpoint(code);
    if (code) return cannotListen(address, code);
    if (tcp) address_.port = portOf(bound);
    return success();
}

void Listener::accept() {
    if (closed_ || waiting_) return;
    acceptor_.async_accept([this](const asio::error_code& code, Socket socket) {
        waiting_ = false;
        take(code, std::move(socket));
    });
    waiting_ = true;
}

void Listener::take(const asio::error_code& code, Socket socket) {
    if (code == asio::error::operation_aborted || closed_) return;
    if (code) {
        log::error("a client cannot be accepted: {}", code.message());
        if (isShortOfDescriptors(code)) refuseAll();
        return acceptAfter(errorPause);
    }
    try {
        if (address_.kind == wire::Address::Kind::tcp) socket.set_option(asio::ip::tcp::no_delay(true));
        events_.accepted(std::move(socket));
    } catch (const std::exception& failure) {
        // It was closed at once, or TLS cannot begin: this connection is lost, those to come are not.
        log::failure("a client cannot be served", failure);
        return acceptAfter(errorPause);
    }
    if (events_.crowded()) return acceptAfter(crowdPause);
    accept();
}

/// Those who wait hold no descriptor of ours yet: with the spare one they are taken, told and closed.
void Listener::refuseAll() {
    for (int i = 0; i < refusedAtOnce; ++i) {
        spare_ = {};
        asio::error_code code;
        Socket socket = acceptor_.accept(code);
        if (!code) events_.refused(std::move(socket));
        spare_ = spareDescriptor();
        if (code) return;
    }
}

void Listener::acceptAfter(std::chrono::milliseconds pause) {
    pause_.expires_after(pause);
    pause_.async_wait([this](const asio::error_code& code) {
        waiting_ = false;
        if (!code) accept();
    });
    waiting_ = true;
}

void Listener::close() {
    closed_ = true;
    asio::error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
}

}  // namespace mote::server
