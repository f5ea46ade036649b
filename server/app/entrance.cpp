// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/entrance.h"

#include <asio/io_context.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "protocol/base/system_error.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "protocol/wire/private_file.h"
#include "server/app/listener.h"
#include "server/session/outbox.h"

namespace mote::server {
namespace {

// A server that was just killed accepts until the kernel has taken it apart.
constexpr int attempts = 50;
constexpr std::chrono::milliseconds attemptPause{10};

/// Whether somebody accepts connections there.
bool alive(const std::string& address) {
    const auto parsed = wire::parseAddress(address);
    if (!parsed.ok()) return false;
    asio::io_context context;
    asio::error_code code;
    const auto endpoint = endpointOf(context, *parsed);
    if (!endpoint.ok()) return false;
    Listener::Socket socket(context);
    socket.connect(*endpoint, code);
    return !code;
}

namespace fs = std::filesystem;

constexpr const char* socketName = "mote.sock";

Status removeStale(const fs::path& path) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) {
        if (errno == ENOENT) return success();
        return Error{ErrorCode::permissionDenied, path.string(), systemMessage(errno)};
    }
    if (!S_ISSOCK(status.st_mode)) {
        return Error{ErrorCode::alreadyExists, path.string(),
                     "is no socket but stands where the server's socket belongs; move it away"};
    }
    if (::unlink(path.c_str()) == 0) return success();
    return Error{ErrorCode::permissionDenied, path.string(), systemMessage(errno)};
}

/// XDG_RUNTIME_DIR, the user's alone and short on every system that has it; else the folder for temporary
/// files.
fs::path runtimeFolder() {
    const char* folder = ::secure_getenv("XDG_RUNTIME_DIR");
    if (folder && *folder == '/' && ::access(folder, W_OK) == 0) return folder;
    std::error_code code;
    const auto temporary = fs::temp_directory_path(code);
    return code ? fs::path("/tmp") : temporary;
}

/// There is no descriptor for it.
void turnAway(wire::MessageStream stream) {
    stream.turnAway(failureMessage(
        0, {ErrorCode::resourceExhausted, "server", "it has no descriptor left; try again later"}, true));
}

wire::MessageStream plain(Listener::Socket socket) {
    return wire::MessageStream(std::move(socket));
}

}  // namespace

Status checkNotInUse(const std::filesystem::path& file) {
    const auto old = wire::readConnectionFile(file);
    if (!old.ok()) return success();
    for (int attempt = 0; attempt < attempts; ++attempt) {
        if (!alive(old->address())) return success();
        std::this_thread::sleep_for(attemptPause);
    }
    return Error{ErrorCode::alreadyExists, file.string(),
                 fmt::format("belongs to a server that runs (process {}); stop it or give --connection "
                             "another file",
                             old->pid())};
}

Result<wire::TlsIdentity> readIdentity(const std::filesystem::path& stateDirectory) {
    const auto path = stateDirectory / "tls.pem";
    auto pem = wire::readPrivateFile(path);
    if (!pem.ok() && pem.error().code == ErrorCode::notFound) {
        MOTE_ASSIGN_OR_RETURN(const auto fresh, wire::TlsIdentity::makePem());
        MOTE_RETURN_IF_ERROR(wire::writePrivateFile(path, fresh));
        pem = fresh;
    }
    if (!pem.ok()) return pem.error();
    auto identity = wire::TlsIdentity::parse(*pem);
    if (identity.ok()) return identity;
    return Error{identity.error().code, path.string(),
                 identity.error().message + "; move it away, and the server makes another"};
}

SocketPlace::~SocketPlace() {
    if (path_.empty()) return;
    ::unlink(path_.c_str());
    if (!folder_.empty()) ::rmdir(folder_.c_str());
}

Result<SocketPlace> SocketPlace::make(const fs::path& stateDirectory) {
    std::error_code code;
    const fs::path wanted = fs::absolute(stateDirectory, code) / socketName;
    if (wanted.native().size() <= wire::maxSocketPath) {
        MOTE_RETURN_IF_ERROR(removeStale(wanted));
        return SocketPlace(wanted, {});
    }
    std::string folder = (runtimeFolder() / "mote-XXXXXX").string();
    if (folder.size() + 1 + std::strlen(socketName) > wire::maxSocketPath) {
        return Error{ErrorCode::invalidArgument, wanted.string(),
                     fmt::format("a socket's path has at most {} bytes; give --state a shorter one",
                                 wire::maxSocketPath)};
    }
    if (!::mkdtemp(folder.data())) {
        return Error{ErrorCode::internal, folder, fmt::format("cannot be made: {}", systemMessage(errno))};
    }
    return SocketPlace(fs::path(folder) / socketName, folder);
}

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
