// SPDX-License-Identifier: GPL-3.0-or-later
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>

#include <asio/read.hpp>
#include <asio/ssl/error.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/write.hpp>
#include <optional>

#include "protocol/wire/await_tuple.h"
#include "protocol/wire/tls.h"
#include "protocol/wire/tls_parts.h"

namespace mote::wire {
namespace {

/// The record of a fatal alert, "internal_error" (RFC 8446, section 6): who has not begun to speak hears by
/// it that there is no place.
constexpr std::array<std::uint8_t, 7> noPlace{21, 3, 3, 0, 2, 2, 80};

/// Framing says where a stream may end; how it is closed beneath is of no interest.
asio::error_code withoutTruncation(asio::error_code code) {
    return code == asio::ssl::error::stream_truncated ? asio::error_code(asio::error::eof) : code;
}

class TlsStream : public ByteStream {
  public:
    using ByteStream::ByteStream;

    asio::awaitable<asio::error_code> read(ToRead parts) override {
        std::size_t done = 0;
        const auto [code, count] = co_await asio::async_read(*tls_, parts, countRead(done), awaitTuple);
        countRead(done, count);
        co_return withoutTruncation(code);
    }

    asio::awaitable<asio::error_code> write(ToWrite parts) override {
        const auto [code, count] =
            co_await asio::async_write(*tls_, parts, countWritten(asio::buffer_size(parts)), awaitTuple);
        co_return withoutTruncation(code);
    }

  protected:
    using Tls = asio::ssl::stream<Socket&>;

    asio::awaitable<asio::error_code> handshake(asio::ssl::context& context, Tls::handshake_type type) {
        tls_.emplace(socket(), context);
        const auto [code] = co_await tls_->async_handshake(type, awaitTuple);
        co_return withoutTruncation(code);
    }

    std::optional<Tls> tls_;
};

class TlsServerStream : public TlsStream {
  public:
    TlsServerStream(Socket socket, const TlsIdentity& identity)
        : TlsStream(std::move(socket)), identity_(identity) {}

    /// Whoever fails here speaks no TLS that could carry a word.
    asio::awaitable<Status> shakeHands() override {
        const auto [waited] = co_await socket().async_wait(Socket::wait_read, awaitTuple);
        if (waited) co_return connectionError(waited);
        const auto code = co_await handshake(identity_.context().tls, Tls::server);
        if (code) co_return Error{ErrorCode::cancelled, "connection", "no TLS: " + code.message()};
        open_ = true;
        co_return success();
    }

    void tryWrite(std::span<const std::uint8_t> bytes) override {
        if (!tls_) return ByteStream::tryWrite(noPlace);
        if (!open_) return;
        asio::error_code ignored;
        socket().non_blocking(true, ignored);
        if (!ignored) tls_->write_some(asio::buffer(bytes.data(), bytes.size()), ignored);
    }

  private:
    const TlsIdentity identity_;
    bool open_ = false;
};

class TlsClientStream : public TlsStream {
  public:
    TlsClientStream(Socket socket, std::string fingerprint)
        : TlsStream(std::move(socket)), fingerprint_(std::move(fingerprint)) {}

    asio::awaitable<Status> shakeHands() override {
        asio::ssl::context context(asio::ssl::context::tlsv13_client);
        // The fingerprint says more than any authority, and is looked at before anything is said.
        context.set_verify_mode(asio::ssl::verify_none);
        const auto code = co_await handshake(context, Tls::client);
        if (code && heardNoPlace()) co_return noPlaceForUs();
        if (code) co_return handshakeError(code);
        const Owned<X509, X509_free> certificate(SSL_get1_peer_certificate(tls_->native_handle()));
        if (certificate && fingerprintOf(*certificate) == fingerprint_) co_return success();
        co_return Error{ErrorCode::permissionDenied, "certificate",
                        "it is not the one whose fingerprint the connection file says: this is another "
                        "server, or somebody stands in between"};
    }

  private:
    /// Who is turned away before its first word may be unable to say it, and has its answer all the same.
    bool heardNoPlace() {
        std::array<std::uint8_t, noPlace.size()> heard{};
        const auto count = ::recv(socket().native_handle(), heard.data(), heard.size(), MSG_DONTWAIT);
        return count == static_cast<ssize_t>(heard.size()) && heard == noPlace;
    }

    static Error noPlaceForUs() {
        return {ErrorCode::resourceExhausted, "server",
                "too many connections that have shown no token are there; try again"};
    }

    static Error handshakeError(const asio::error_code& code) {
        if (code.category() != asio::error::get_ssl_category()) return connectionError(code);
        if (ERR_GET_REASON(static_cast<unsigned long>(code.value())) == SSL_R_TLSV1_ALERT_INTERNAL_ERROR)
            return noPlaceForUs();
        return {ErrorCode::unsupported, "connection", "no TLS 1.3 with this server: " + code.message()};
    }

    std::string fingerprint_;
};

}  // namespace

std::unique_ptr<ByteStream> tlsServerStream(ByteStream::Socket socket, const TlsIdentity& identity) {
    return std::make_unique<TlsServerStream>(std::move(socket), identity);
}

std::unique_ptr<ByteStream> tlsClientStream(ByteStream::Socket socket, std::string fingerprint) {
    return std::make_unique<TlsClientStream>(std::move(socket), std::move(fingerprint));
}

}  // namespace mote::wire
