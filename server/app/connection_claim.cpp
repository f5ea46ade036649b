// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/connection_claim.h"

#include <fmt/format.h>

#include <asio/io_context.hpp>
#include <asio/local/stream_protocol.hpp>
#include <chrono>
#include <thread>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"

namespace mote::server {
namespace {

using Protocol = asio::local::stream_protocol;

// A server that was just killed accepts until the kernel has taken it apart.
constexpr int attempts = 50;
constexpr std::chrono::milliseconds pause{10};

/// Whether somebody accepts connections there.
bool alive(const std::string& address) {
    const auto parsed = wire::parseAddress(address);
    if (!parsed.ok() || parsed->kind != wire::Address::Kind::unixSocket) return false;
    asio::io_context context;
    Protocol::socket socket(context);
    asio::error_code code;
    socket.connect(Protocol::endpoint(parsed->path), code);
    return !code;
}

}  // namespace

Status checkNotInUse(const std::filesystem::path& file) {
    const auto old = wire::readConnectionFile(file);
    if (!old.ok()) return success();
    for (int attempt = 0; attempt < attempts; ++attempt) {
        if (!alive(old->address())) return success();
        std::this_thread::sleep_for(pause);
    }
    return Error{ErrorCode::alreadyExists, file.string(),
                 fmt::format("belongs to a server that runs (process {}); stop it or give --connection "
                             "another file",
                             old->pid())};
}

void removeIfOurs(const std::filesystem::path& file, const std::string& token) {
    const auto content = wire::readConnectionFile(file);
    if (token.empty() || !content.ok() || content->token() != token) return;
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
}

}  // namespace mote::server
