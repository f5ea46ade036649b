// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/http_listener.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/read_until.hpp>
#include <asio/steady_timer.hpp>
#include <asio/write.hpp>
#include <chrono>
#include <cstring>

namespace mote::server {
namespace {

using Socket = asio::generic::stream_protocol::socket;
using namespace std::chrono_literals;

constexpr unsigned mostConnections = 8;
constexpr auto longestConnection = 5s;

/// One request and its answer. Owned by what it waits for.
class Connection : public std::enable_shared_from_this<Connection> {
  public:
    Connection(Socket socket, std::shared_ptr<const HttpPages> pages, std::shared_ptr<unsigned> open)
        : socket_(std::move(socket)),
          deadline_(socket_.get_executor()),
          pages_(std::move(pages)),
          open_(std::move(open)) {
        ++*open_;
    }
    ~Connection() { --*open_; }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    void start() {
        deadline_.expires_after(longestConnection);
        deadline_.async_wait([weak = weak_from_this()](const asio::error_code& code) {
            const auto self = weak.lock();
            if (!code && self) self->close();
        });
        asio::async_read_until(socket_, asio::dynamic_buffer(head_, longestHttpHead), "\r\n\r\n",
                               [self = shared_from_this()](const asio::error_code& code, std::size_t size) {
                                   self->answer(code, size);
                               });
    }

  private:
    void answer(const asio::error_code& code, std::size_t size) {
        // Asio's word for a buffer that is full.
        if (code == asio::error::not_found) {
            answer_ = httpTooLong();
        } else if (code) {
            return close();
        } else {
            answer_ = httpAnswer(std::string_view(head_).substr(0, size), *pages_);
        }
        asio::async_write(
            socket_, asio::buffer(answer_),
            [self = shared_from_this()](const asio::error_code&, std::size_t) { self->close(); });
    }

    void close() {
        deadline_.cancel();
        asio::error_code ignored;
        socket_.shutdown(Socket::shutdown_both, ignored);
        socket_.close(ignored);
    }

    Socket socket_;
    asio::steady_timer deadline_;
    const std::shared_ptr<const HttpPages> pages_;
    const std::shared_ptr<unsigned> open_;
    std::string head_, answer_;
};

/// A socket that a server left behind goes; one that somebody listens at stays.
Status removeStale(asio::io_context& context, const std::string& path) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) return success();
    asio::local::stream_protocol::socket probe(context);
    asio::error_code code;
    if (S_ISSOCK(status.st_mode)) probe.connect(asio::local::stream_protocol::endpoint(path), code);
    if (!S_ISSOCK(status.st_mode) || !code) {
        return Error{ErrorCode::alreadyExists, "--metrics", fmt::format("{} is there already", path)};
    }
    ::unlink(path.c_str());
    return success();
}

}  // namespace

Result<std::unique_ptr<HttpListener>> HttpListener::open(asio::io_context& context,
                                                         const std::string& address, HttpPages pages) {
    auto listener = std::unique_ptr<HttpListener>(new HttpListener(context, std::move(pages)));
    MOTE_RETURN_IF_ERROR(listener->listen(address));
    listener->accept();
    return listener;
}

HttpListener::HttpListener(asio::io_context& context, HttpPages pages)
    : context_(context),
      pages_(std::make_shared<const HttpPages>(std::move(pages))),
      acceptor_(context),
      pause_(context) {}

HttpListener::~HttpListener() {
    if (!socket_.empty()) ::unlink(socket_.c_str());
}

Result<wire::Address> HttpListener::parse(const std::string& address) {
    auto parsed = wire::parseAddress(address.starts_with("unix:") ? address : "tcp:" + address);
    if (parsed.ok() && parsed->kind == wire::Address::Kind::unixSocket) return parsed;
    asio::error_code code;
    if (parsed.ok() && asio::ip::make_address(parsed->host, code).is_loopback()) return parsed;
    return Error{ErrorCode::invalidArgument, "--metrics",
                 fmt::format("\"{}\" is neither unix:PATH nor 127.0.0.1:PORT", address)};
}

Status HttpListener::listen(const std::string& address) {
    MOTE_ASSIGN_OR_RETURN(const auto place, parse(address));
    if (place.kind == wire::Address::Kind::unixSocket) {
        MOTE_RETURN_IF_ERROR(removeStale(context_, place.path));
        MOTE_RETURN_IF_ERROR(listenAt(asio::local::stream_protocol::endpoint(place.path), AF_UNIX));
        socket_ = place.path;
        address_ = address;
        return success();
    }
    const asio::ip::tcp::endpoint wanted(asio::ip::make_address(place.host), place.port);
    MOTE_RETURN_IF_ERROR(listenAt(wanted, wanted.protocol().family()));
    asio::ip::tcp::endpoint found;
    asio::error_code code;
    const auto taken = acceptor_.local_endpoint(code);
    std::memcpy(found.data(), taken.data(), std::min(taken.size(), found.capacity()));
    address_ = fmt::format("{}:{}", wanted.address().is_v6() ? fmt::format("[{}]", place.host) : place.host,
                           found.port());
    return success();
}

Status HttpListener::listenAt(const Protocol::endpoint& endpoint, int family) {
    asio::error_code code;
    acceptor_.open(Protocol(family, 0), code);
    const asio::socket_base::reuse_address again(family != AF_UNIX);
    if (!code && family != AF_UNIX) acceptor_.set_option(again, code);
    const mode_t mask = ::umask(0177);
    if (!code) acceptor_.bind(endpoint, code);
    ::umask(mask);
    if (!code) acceptor_.listen(asio::socket_base::max_listen_connections, code);
    if (!code) return success();
    const bool taken = code == asio::error::address_in_use;
    return Error{taken ? ErrorCode::alreadyExists : ErrorCode::internal, "--metrics",
                 "cannot listen: " + code.message()};
}

void HttpListener::accept() {
    acceptor_.async_accept([this](const asio::error_code& code, Socket socket) {
        if (code == asio::error::operation_aborted) return;
        if (code) return acceptLater();
        accept();
        if (*connections_ >= mostConnections) return;
        std::make_shared<Connection>(std::move(socket), pages_, connections_)->start();
    });
}

/// Without a descriptor left, accepting again at once would spin.
void HttpListener::acceptLater() {
    pause_.expires_after(200ms);
    pause_.async_wait([this](const asio::error_code& code) {
        if (!code) accept();
    });
}

}  // namespace mote::server
