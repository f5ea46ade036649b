// SPDX-License-Identifier: GPL-3.0-or-later
//
// Address: where a server listens, as its connection file says: "unix:/path" or "tcp:host:port". A value.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "protocol/base/error.h"

namespace mote::wire {

struct Address {
    enum class Kind { unixSocket, tcp };

    Kind kind = Kind::unixSocket;
    std::string path;        ///< of a Unix socket
    std::string host;        ///< of TCP: a name or a number; [::1] without its brackets
    std::uint16_t port = 0;  ///< of TCP

    static Address unixAt(std::string path) { return {Kind::unixSocket, std::move(path), {}, 0}; }
    std::string toString() const;
    bool operator==(const Address&) const = default;
};

/// The longest path of a Unix socket, bytes: what the kernel's sockaddr_un holds beside its final zero.
inline constexpr std::size_t maxSocketPath = 107;

/// Errors: invalidArgument (no kind, an empty or too long path, a port that is none).
Result<Address> parseAddress(std::string_view text);

}  // namespace mote::wire
