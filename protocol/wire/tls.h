// SPDX-License-Identifier: GPL-3.0-or-later
//
// TLS 1.3, and nothing older, between a server with a certificate of its own making and clients that know the
// certificate's fingerprint: no authorities, no names, no dates. The only header of ours that stands for
// OpenSSL. Identities are values, for any thread; streams are as ByteStream.
#pragma once

#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/wire/byte_stream.h"

namespace mote::wire {

/// A server's key and certificate.
class TlsIdentity {
  public:
    /// A fresh pair, as the text of a PEM file: an EC key (P-256) and a self-signed certificate without an
    /// end. Errors: internal (no random numbers).
    static Result<std::string> makePem();
    /// Errors: corrupt (no such text, or the key is another certificate's).
    static Result<TlsIdentity> parse(const std::string& pem);

    /// The certificate's SHA-256, 64 hexadecimal digits.
    const std::string& fingerprint() const { return fingerprint_; }

    struct Context;
    const Context& context() const { return *context_; }

  private:
    TlsIdentity(std::shared_ptr<const Context> context, std::string fingerprint)
        : context_(std::move(context)), fingerprint_(std::move(fingerprint)) {}

    std::shared_ptr<const Context> context_;
    std::string fingerprint_;
};

/// Whether it is what TlsIdentity::fingerprint() gives.
bool isFingerprint(const std::string& text);

/// Takes memory for TLS once the client has begun to speak.
std::unique_ptr<ByteStream> tlsServerStream(ByteStream::Socket socket, const TlsIdentity& identity);

/// Nothing is said to a server whose certificate has another fingerprint. Errors of shakeHands() besides:
/// permissionDenied (another fingerprint), resourceExhausted (the server takes nobody on now), unsupported
/// (no TLS 1.3).
std::unique_ptr<ByteStream> tlsClientStream(ByteStream::Socket socket, std::string fingerprint);

}  // namespace mote::wire
