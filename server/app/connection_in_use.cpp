// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/connection_in_use.h"

#include <fmt/format.h>

#include <asio/io_context.hpp>
#include <chrono>
#include <string>
#include <thread>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "server/app/listener.h"

namespace mote::server {
namespace {

// A server that was just killed accepts until the kernel has taken it apart.
constexpr int attempts = 50;
constexpr std::chrono::milliseconds pause{10};

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

}  // namespace mote::server
