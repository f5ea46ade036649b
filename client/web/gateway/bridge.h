// SPDX-License-Identifier: GPL-3.0-or-later
//
// The bridge from a browser's WebSocket to a connection to mote-server. Each binary message of the WebSocket
// is one frame of the protocol. The token of the server's never reaches the browser: it is put into the
// browser's hello here. The thread of the gateway.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "client/web/gateway/access.h"
#include "client/web/gateway/browser_stream.h"
#include "protocol/scene/error.h"

namespace mote::web {

struct BridgeSettings {
    std::filesystem::path connectionFile;
    Role role = Role::nobody;
};

/// Pipes until either end ends. The WebSocket has been accepted; its last word says why it ends, where that
/// is not the browser's own wish: 1013 (the server is not there: try again), 1008 (what the browser sent is
/// not the protocol, or not allowed), 1011 (the server ended).
boost::asio::awaitable<void> runBridge(WebSocket& browser, BridgeSettings settings);

/// A message of a browser's as it goes on to the server: checked, and the first one with the server's token
/// in place of the browser's. Errors: corrupt (no whole frame of the protocol), permissionDenied (not for
/// this role), resourceExhausted (too long).
class FromBrowser {
  public:
    FromBrowser(Role role, std::string token) : role_(role), token_(std::move(token)) {}

    /// What is to be sent: valid until the next call, and `message` must be, too.
    Result<std::span<const std::uint8_t>> take(std::span<const std::uint8_t> message);

  private:
    Role role_;
    std::string token_;
    bool greeted_ = false;
    std::vector<std::uint8_t> rewritten_;
};

}  // namespace mote::web
