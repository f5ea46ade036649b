// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the sources of TLS share; nobody else includes it, as it brings OpenSSL and asio/ssl. Any thread.
#pragma once

#include <openssl/x509.h>

#include <asio/ssl/context.hpp>
#include <memory>
#include <string>

#include "protocol/wire/tls.h"

namespace mote::wire {

struct TlsIdentity::Context {
    mutable asio::ssl::context tls{asio::ssl::context::tlsv13_server};
};

/// Gives back what OpenSSL made: Owned<X509, X509_free>.
template <class T, void (*release)(T*)>
struct Release {
    void operator()(T* object) const { release(object); }
};
template <class T, void (*release)(T*)>
using Owned = std::unique_ptr<T, Release<T, release>>;

/// SHA-256 of the whole certificate.
std::string fingerprintOf(const X509& certificate);

}  // namespace mote::wire
