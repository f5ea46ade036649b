// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <array>

#include "protocol/wire/tls.h"
#include "protocol/wire/tls_parts.h"

namespace mote::wire {
namespace {

using Key = Owned<EVP_PKEY, EVP_PKEY_free>;
using Certificate = Owned<X509, X509_free>;
using Bio = Owned<BIO, BIO_free_all>;

/// What a certificate without an end says (RFC 5280, section 4.1.2.5).
constexpr const char* noEnd = "99991231235959Z";
constexpr long yesterday = -24L * 3600;

Error noIdentity() {
    return {ErrorCode::internal, "certificate", "no key and certificate can be made"};
}

bool setSerial(X509* certificate) {
    std::array<unsigned char, 8> bytes{};
    if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) return false;
    std::uint64_t serial = 0;
    for (const auto byte : bytes) serial = serial << 8U | byte;
    return ASN1_INTEGER_set_uint64(X509_get_serialNumber(certificate), serial >> 1U) == 1;
}

/// Both names are the server's: it signs for itself.
bool setNames(X509* certificate) {
    X509_NAME* name = X509_get_subject_name(certificate);
    const auto* text = reinterpret_cast<const unsigned char*>("mote-server");
    return X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, text, -1, -1, 0) == 1 &&
           X509_set_issuer_name(certificate, name) == 1;
}

bool fill(X509* certificate, EVP_PKEY* key) {
    return X509_set_version(certificate, X509_VERSION_3) == 1 && setSerial(certificate) &&
           setNames(certificate) && X509_gmtime_adj(X509_getm_notBefore(certificate), yesterday) != nullptr &&
           ASN1_TIME_set_string(X509_getm_notAfter(certificate), noEnd) == 1 &&
           X509_set_pubkey(certificate, key) == 1 && X509_sign(certificate, key, EVP_sha256()) > 0;
}

std::string textOf(BIO* bio) {
    char* data = nullptr;
    const long size = BIO_get_mem_data(bio, &data);
    return {data, static_cast<std::size_t>(size)};
}

}  // namespace

std::string fingerprintOf(const X509& certificate) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    if (X509_digest(&certificate, EVP_sha256(), digest.data(), &size) != 1) return {};
    std::string text;
    for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
}

bool isFingerprint(const std::string& text) {
    const auto hexadecimal = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
    return text.size() == 64 && std::all_of(text.begin(), text.end(), hexadecimal);
}

Result<std::string> TlsIdentity::makePem() {
    const Key key(EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256"));
    const Certificate certificate(X509_new());
    const Bio out(BIO_new(BIO_s_mem()));
    if (!key || !certificate || !out || !fill(certificate.get(), key.get())) return noIdentity();
    if (PEM_write_bio_PrivateKey(out.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) != 1 ||
        PEM_write_bio_X509(out.get(), certificate.get()) != 1) {
        return noIdentity();
    }
    return textOf(out.get());
}

Result<TlsIdentity> TlsIdentity::parse(const std::string& pem) {
    const auto read = [&](auto function) {
        const Bio in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
        // A password is never asked for at the terminal.
        const auto none = [](char*, int, int, void*) { return 0; };
        return function(in.get(), nullptr, none, nullptr);
    };
    const Key key(read(PEM_read_bio_PrivateKey));
    const Certificate certificate(read(PEM_read_bio_X509));
    ERR_clear_error();
    const auto context = std::make_shared<Context>();
    SSL_CTX* tls = context->tls.native_handle();
    if (!key || !certificate || SSL_CTX_use_certificate(tls, certificate.get()) != 1 ||
        SSL_CTX_use_PrivateKey(tls, key.get()) != 1 || SSL_CTX_check_private_key(tls) != 1) {
        ERR_clear_error();
        return Error{ErrorCode::corrupt, "", "holds no key with its certificate"};
    }
    // Sessions are taken up again by Mote itself; what TLS keeps for that is of no use.
    SSL_CTX_set_num_tickets(tls, 0);
    SSL_CTX_set_session_cache_mode(tls, SSL_SESS_CACHE_OFF);
    return TlsIdentity(context, fingerprintOf(*certificate));
}

}  // namespace mote::wire
